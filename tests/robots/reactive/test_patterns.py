"""TRANSPORT's patterns 1-5 are table 2's."""

import pytest

from robots.reactive.patterns import BehaviourPattern
from robots.reactive.synthesis import DegreeOfFreedom, Utilitor, superpose
from robots.repertoire import load_repertoire
from tests.robots.sensed import percepts, sees

TRANSPORT = load_repertoire().specs["TRANSPORT"].bind({"object": "sample", "ref1": "door", "ref2": "bay"})
CRUISE = Utilitor.normalised(0.5, 0.5)


def pattern(dof: DegreeOfFreedom, name: str) -> BehaviourPattern:
    return next(one for one in TRANSPORT.patterns if (one.dof, one.name) == (dof, name))


AVOID = pattern(DegreeOfFreedom.TRANSLATE, "obstacle_avoid")
TURN_AWAY = pattern(DegreeOfFreedom.ROTATE, "obstacle_avoid")
FOLLOW = pattern(DegreeOfFreedom.TRANSLATE, "centre_capture_head")
TURN_AFTER = pattern(DegreeOfFreedom.ROTATE, "centre_capture_head")


def test_translate_generates_a_constant_response_with_constant_utility() -> None:
    got = pattern(DegreeOfFreedom.TRANSLATE, "translate").respond(percepts(sees("bay", 4)))
    assert (got.response, got.u) == (0.5, 0.5)


def test_translate_has_no_utility_out_of_its_context() -> None:
    there = percepts(sees("bay", 0.8))
    assert pattern(DegreeOfFreedom.TRANSLATE, "translate").respond(there).u == 0


@pytest.mark.parametrize(("range_m", "s"), [(0.3, 0.0), (0.15, 0.5), (0.0, 1.0)])
def test_obstacle_avoidance_responds_by_minus_s_with_utility_s(range_m: float, s: float) -> None:
    got = AVOID.respond(percepts(sees("bay", 4), whiskers={0: range_m + 0.02}))
    assert (got.response, got.u) == (pytest.approx(-s), pytest.approx(s))


def test_an_obstacle_at_half_its_proximity_cancels_translate_exactly() -> None:
    assert superpose(
        [CRUISE, AVOID.respond(percepts(sees("bay", 4), whiskers={0: 0.17}))]
    ).r == pytest.approx(0)


def test_an_obstacle_at_touch_drives_the_robot_backwards() -> None:
    assert superpose([CRUISE, AVOID.respond(percepts(sees("bay", 4), whiskers={0: 0.0}))]).response < -0.5


@pytest.mark.parametrize(("beam", "turn"), [(15, 1.0), (1, -1.0), (0, -1.0)])
def test_rotation_turns_away_from_the_obstacle_and_right_from_one_dead_ahead(beam: int, turn: float) -> None:
    got = TURN_AWAY.respond(percepts(sees("bay", 4), whiskers={beam: 0.05}))
    assert got.response == turn
    assert got.u > 0


@pytest.mark.parametrize("deflection_m", [-0.05, -0.02, 0.01, 0.04])
def test_capture_head_is_followed_slowly_in_translation_and_quickly_in_rotation(deflection_m: float) -> None:
    s = deflection_m / 0.05
    ahead = FOLLOW.respond(percepts(head=(deflection_m, 0.0)))
    aside = TURN_AFTER.respond(percepts(head=(0.0, deflection_m)))
    assert ahead.u == aside.u == pytest.approx(abs(s) ** 0.5)
    assert aside.response == pytest.approx(abs(s) ** 0.5 * (1 if s > 0 else -1))
    assert abs(ahead.response) == pytest.approx(1 - (1 - abs(s)) ** 0.5)
    assert abs(ahead.response) <= abs(aside.response)


def test_an_idle_capture_head_has_no_utility() -> None:
    assert FOLLOW.respond(percepts()).u == TURN_AFTER.respond(percepts()).u == 0


def test_every_pattern_stays_normalised_whatever_is_sensed() -> None:
    instant = percepts(
        sees("bay", 0.1, 3), sees("other", 0.3), whiskers=dict.fromkeys(range(16), 0.0), head=(9, -9)
    )
    for name in ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE1 (long)", "RELEASE2", "TRACK"):
        spec = load_repertoire().specs[name]
        bound = spec.bind({"object": "sample", "ref1": "bay", "ref2": "bay", "robot2": "other"})
        for one in (*bound.patterns, *bound.waiting):
            got = one.respond(instant)
            assert -1 <= got.response <= 1
            assert 0 <= got.u <= 1
