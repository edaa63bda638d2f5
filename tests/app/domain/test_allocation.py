"""Legs go to the cheapest bidders one after the other; a joint leg goes to the pair that costs least together."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.domain.allocation import Award, TenderedLeg, allocate, price_of, without
from robots.executive.offer import Offer


def offer(way_s: float, work_s: float = 10.0, *, release_s: float = 0.0, more_s: float = 0.0) -> Offer:
    """:param more_s: what the bid counts beside release, way and work, such as charging."""
    return Offer(
        cost_s=release_s + way_s + work_s + more_s,
        release_s=release_s,
        way_s=way_s,
        work_s=work_s,
        battery=0.9,
    )


def leg(name: str, *parts: dict[str, Offer]) -> TenderedLeg:
    return TenderedLeg(id=name, parts=parts)


def teams(*legs: TenderedLeg) -> dict[str, tuple[str, ...]]:
    return {name: award.team for name, award in allocate(legs).items()}


def test_a_leg_goes_to_the_cheapest_bid() -> None:
    assert teams(leg("a", {"fred": offer(20), "ginger": offer(5)})) == {"a": ("ginger",)}


def test_the_next_best_is_told() -> None:
    award = allocate([leg("a", {"fred": offer(20), "ginger": offer(5)})])["a"]
    assert award == Award(leg="a", team=("ginger",), price_s=15.0, next_team=("fred",), next_price_s=30.0)


def test_earlier_awards_make_a_robot_busy() -> None:
    near = {"fred": offer(5, 30), "ginger": offer(8, 30)}
    awards = allocate([leg("a", near), leg("b", near), leg("c", near)])
    assert {name: award.team for name, award in awards.items()} == {
        "a": ("fred",),
        "b": ("ginger",),
        "c": ("fred",),
    }
    assert awards["c"].busy_s == {"fred": 35.0}
    assert awards["c"].price_s == 70.0


def test_the_cheapest_leg_is_awarded_first_whatever_the_order() -> None:
    far = {"fred": offer(50), "ginger": offer(80)}
    near = {"fred": offer(5)}
    assert teams(leg("far", far), leg("near", near)) == {"near": ("fred",), "far": ("fred",)}
    busy = allocate([leg("far", far), leg("near", near)])["far"].busy_s
    assert busy == {"fred": 15.0}


def test_a_leg_without_bids_is_not_awarded() -> None:
    assert teams(leg("a", {}), leg("b", {"fred": offer(1)})) == {"b": ("fred",)}


def test_a_joint_leg_goes_to_the_pair_that_costs_least_together() -> None:
    """fred is nearest, but each pair waits for the later of both."""
    one = {"fred": offer(1), "ginger": offer(20), "rose": offer(12)}
    other = {"fred": offer(1), "ginger": offer(4), "rose": offer(30)}
    assert teams(leg("carry", one, other)) == {"carry": ("fred", "ginger")}


def test_a_joint_leg_waits_for_the_later_release() -> None:
    free = offer(10)
    busy = offer(1, release_s=30.0)
    assert price_of([free, busy], [0.0, 0.0]) == 41.0
    assert price_of([free, busy], [50.0, 0.0]) == 70.0


def test_what_members_need_beside_is_added_up() -> None:
    assert price_of([offer(5, 10, more_s=7), offer(5, 12, more_s=2)], [0.0, 0.0]) == 5 + 12 + 9


def test_nobody_is_in_a_team_twice() -> None:
    assert teams(leg("carry", {"fred": offer(1)}, {"fred": offer(1)})) == {}


def test_without_a_member_the_next_team_is_formed() -> None:
    one = {"fred": offer(1), "rose": offer(12)}
    other = {"ginger": offer(4), "rose": offer(6)}
    joint = leg("carry", one, other)
    assert teams(joint) == {"carry": ("fred", "ginger")}
    assert teams(without(joint, {"ginger"})) == {"carry": ("fred", "rose")}
    assert teams(without(joint, {"fred"})) == {"carry": ("rose", "ginger")}
    assert teams(without(joint, {"fred", "rose"})) == {}


@pytest.mark.parametrize("bidders", [60])
def test_of_very_many_teams_those_of_cheap_bidders_are_compared(bidders: int) -> None:
    part = {f"robot_{n:02}": offer(float(n)) for n in range(bidders)}
    assert teams(leg("carry", part, part)) == {"carry": ("robot_00", "robot_01")}


@given(
    st.lists(st.dictionaries(st.sampled_from("abcd"), st.floats(0, 100), max_size=4), min_size=1, max_size=5)
)
def test_each_leg_that_is_bid_for_is_awarded_to_a_bidder(bids: list[dict[str, float]]) -> None:
    legs = [
        leg(str(n), {robot: offer(way_s) for robot, way_s in each.items()}) for n, each in enumerate(bids)
    ]
    awards = allocate(legs)
    assert awards.keys() == {one.id for one in legs if one.parts[0]}
    assert all(awards[one.id].team[0] in one.parts[0] for one in legs if one.parts[0])
