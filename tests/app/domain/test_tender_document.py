"""A goal's tender: who is awarded what, who may be recruited, and what happens when a winner fails."""

from app.domain.tender_document import BidBody, BidState, LegBody, OfferBody, PartBody, TenderBody
from robots.executive.offer import Declining
from tests.app.sample_store import said

ROBOTS = ("fred", "ginger", "rose")
FIRST = said("in(sample_1, bay_7)")
SECOND = said("in(sample_2, bay_8)")


def offered(robot: str, cost_s: float) -> BidBody:
    offer = OfferBody(cost_s=cost_s, release_s=0.0, way_s=cost_s - 10.0, work_s=10.0, battery=0.9)
    return BidBody(robot=robot, state=BidState.OFFERED, offer=offer)


def other(robot: str, state: BidState) -> BidBody:
    return BidBody(robot=robot, state=state, reason="its gripper is stuck")


def leg(name: str, *bids: BidBody, goal: object = FIRST) -> LegBody:
    part = PartBody(robot="fred", tags=("DOCK",), conversation=f"call-{name}", bids=bids)
    return LegBody(id=name, goal=goal, parts=(part,))


def tender(*legs: LegBody) -> TenderBody:
    return TenderBody(attempt=1, legs=legs).allocated()


def test_who_is_awarded_a_leg_is_recruited_for_its_goal_alone() -> None:
    made = tender(leg("leg_1", offered("fred", 30), offered("ginger", 20)))
    assert made.legs[0].team == ("ginger",)
    assert made.legs[0].why == "ginger asks 20 s, the next best, fred, 30 s"
    assert made.recruits(ROBOTS) == {FIRST: frozenset({"ginger"})}


def test_where_nobody_bids_those_may_be_recruited_who_have_not_declined() -> None:
    bids = (
        other("fred", BidState.DECLINED),
        other("ginger", BidState.SILENT),
        other("rose", BidState.UNCALLED),
    )
    assert tender(leg("leg_1", *bids)).recruits(ROBOTS) == {FIRST: frozenset({"ginger", "rose"})}


def test_a_goal_for_which_all_may_be_recruited_is_left_out() -> None:
    assert tender(leg("leg_1", *(other(robot, BidState.SILENT) for robot in ROBOTS))).recruits(ROBOTS) == {}


def test_what_planning_does_not_recruit_is_listed_and_not_awarded() -> None:
    withheld = offered("fred", 1).model_copy(update={"state": BidState.WITHHELD})
    assert tender(leg("leg_1", withheld, offered("rose", 50))).legs[0].team == ("rose",)


def busy(robot: str, cost_s: float, release_s: float = 5.0) -> BidBody:
    bid = offered(robot, cost_s)
    assert bid.offer is not None
    offer = bid.offer.model_copy(update={"release_s": release_s, "way_s": cost_s - release_s - 10.0})
    return bid.model_copy(update={"state": BidState.BUSY, "offer": offer})


def test_a_busy_robot_is_awarded_nothing_and_waited_for_if_that_saves_enough() -> None:
    made = tender(leg("leg_1", busy("fred", 40), offered("rose", 51)))
    assert made.legs[0].team == ("rose",)
    postponement = made.postponement()
    assert postponement is not None
    assert postponement.robots == {"fred": 5.0}
    assert str(postponement) == "fred asks 40 s, robots that are free ask 51 s"
    assert tender(leg("leg_1", busy("fred", 42), offered("rose", 51))).postponement() is None
    assert made.postponement(impatient=("fred",)) is None


def test_a_busy_robot_is_waited_for_where_too_few_others_bid() -> None:
    made = tender(leg("leg_1", busy("fred", 40), other("rose", BidState.DECLINED)))
    assert str(made.postponement()) == "fred asks 40 s, too few robots that are free bid"
    assert made.recruits(ROBOTS) == {FIRST: frozenset({"ginger"})}


def test_nobody_is_waited_for_if_a_leg_stays_without_a_team() -> None:
    assert tender(leg("leg_1", busy("fred", 40)), leg("leg_2", goal=SECOND)).postponement() is None


def test_nobody_is_waited_for_if_the_first_plans_robot_has_not_answered() -> None:
    made = tender(leg("leg_1", other("fred", BidState.SILENT), busy("ginger", 40)))
    assert made.postponement() is None


def test_the_dearest_leg_decides_whether_a_busy_robot_is_waited_for() -> None:
    first = leg("leg_1", busy("ginger", 40), offered("rose", 100))
    second = leg("leg_2", offered("rose", 100), goal=SECOND)
    postponement = tender(first, second).postponement()
    assert postponement is not None, "rose would do one leg after the other"
    assert (postponement.price_s, postponement.otherwise_s) == (100.0, 200.0)
    assert tender(first, leg("leg_2", offered("fred", 300), goal=SECOND)).postponement() is None


def test_a_leg_at_which_its_robot_failed_goes_to_the_next_best_and_the_others_stay() -> None:
    both = (offered("fred", 30), offered("ginger", 20))
    made = tender(leg("leg_1", *both), leg("leg_2", offered("ginger", 25), offered("rose", 90), goal=SECOND))
    assert [one.team for one in made.legs] == [("ginger",), ("ginger",)]
    again = made.reallocated(lambda one, robot: one.id == "leg_1" and robot == "ginger")
    assert [one.team for one in again.legs] == [("fred",), ("ginger",)]
    assert (again.legs[0].failed, again.legs[1].failed) == (("ginger",), ())
    assert again.legs[0].why.endswith("ginger failed at it")


def test_a_leg_for_which_nobody_else_has_bid_keeps_its_robot() -> None:
    made = tender(leg("leg_1", offered("fred", 30), other("ginger", BidState.DECLINED)))
    assert made.reallocated(lambda one, robot: True) == made


def test_a_plan_keeps_to_an_award_if_the_team_works_for_the_goal() -> None:
    made = tender(leg("leg_1", offered("fred", 30)), leg("leg_2", offered("rose", 30), goal=SECOND))
    planned = made.as_planned({FIRST: frozenset({"fred", "ginger"}), SECOND: frozenset({"fred"})})
    assert [one.is_planned for one in planned.legs] == [True, False]


def test_without_awards_those_who_declined_are_still_left_out() -> None:
    made = tender(leg("leg_1", offered("fred", 30), other("ginger", BidState.DECLINED)))
    assert made.without_awards().recruits(ROBOTS) == {FIRST: frozenset({"fred", "rose"})}
    assert made.without_awards().declines == ["ginger declines leg_1: its gripper is stuck"]


def test_a_leg_that_nobody_is_awarded_waits_for_those_whose_reasons_to_decline_may_pass() -> None:
    low = other("fred", BidState.DECLINED).model_copy(update={"declining": Declining.BATTERY})
    unable = other("ginger", BidState.DECLINED).model_copy(update={"declining": Declining.CANNOT})
    made = tender(leg("leg_1", low, unable), leg("leg_2", low, offered("rose", 5), goal=SECOND))
    assert made.passing.robots == {"fred": "which declines leg_1: its gripper is stuck"}
    assert not tender(leg("leg_1", unable)).passing
