"""close(object), moving(object), narrow_passage: words that conditions may use."""

from pydantic import TypeAdapter

from robots.conditions.beliefs import Believed, Close, Inside, Moving, NarrowPassage, RollsTo
from robots.conditions.composition import AnyCondition
from robots.perception.percepts import Percepts
from tests.robots.sensed import percepts, readings, sees, watch


def approaching(step_m: float) -> Percepts:
    return watch([readings(sees("other", 2 - step_m * tick)) for tick in range(40)])


def test_close_needs_nearness_and_evidence() -> None:
    assert Close(object="ball").check(percepts(sees("ball", 0.9))).holds
    assert not Close(object="ball").check(percepts(sees("ball", 1.2))).holds
    assert not Close(object="ball").check(percepts(sees("ball", 0.9), for_s=0)).holds
    assert not Close(object="ball").check(percepts()).holds


def test_moving_is_believed_of_what_moves() -> None:
    assert Moving(object="other").check(approaching(0.02)).holds
    assert not Moving(object="other").check(approaching(0.0)).holds


def test_things_that_only_whiskers_tell_of_are_believed_in_too() -> None:
    assert Believed(object="thing_1").check(percepts(whiskers={4: 0.6})).holds
    assert Close(object="thing_1").check(percepts(whiskers={4: 0.6})).holds


def test_a_narrow_passage_has_something_near_on_both_sides() -> None:
    for left_m, right_m, holds in ((0.2, 0.2, True), (0.2, 1.5, False), (0.2, None, False)):
        met = {4: left_m} | ({12: right_m} if right_m is not None else {})
        assert NarrowPassage().check(percepts(whiskers=met)).holds is holds


def rolls(percepts: Percepts, x_m: float, least_m_s: float) -> bool:
    """Whether the other thing is believed to move to a point on the x axis."""
    return RollsTo(object="other", x_m=x_m, y_m=0.0, least_m_s=least_m_s).check(percepts).holds


def test_what_approaches_moves_to_the_robot_and_not_away_from_it() -> None:
    comes = approaching(0.02)  # at 0.4 m/s, towards the west
    assert rolls(comes, -5.0, 0.2)
    assert not rolls(comes, -5.0, 0.9)
    assert not rolls(comes, 5.0, 0.2)
    assert not rolls(approaching(0.0), -5.0, 0.2)


def test_a_tracked_thing_is_inside_a_rectangle_or_not() -> None:
    seen = percepts(sees("ball", 0.9))
    at = seen.cursors["ball"].at
    around = ((at.real - 0.2, at.real + 0.2), (at.imag - 0.2, at.imag + 0.2))
    assert Inside(object="ball", x=around[0], y=around[1]).check(seen).holds
    assert not Inside(object="ball", x=(at.real + 0.1, at.real + 1), y=around[1]).check(seen).holds
    assert not Inside(object="ball", x=around[0], y=around[1]).check(percepts()).holds


def test_data_may_state_them() -> None:
    words = [
        {"sense": "close", "object": "ball", "m": 0.5},
        {"sense": "moving", "object": "ball"},
        {"sense": "believed", "object": "ball"},
        {"sense": "narrow_passage"},
    ]
    read = TypeAdapter(tuple[AnyCondition, ...]).validate_python(words)
    assert [type(one) for one in read] == [Close, Moving, Believed, NarrowPassage]
