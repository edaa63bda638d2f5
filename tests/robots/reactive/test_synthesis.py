"""Behaviour synthesis is MACTA's eqs 1-3."""

from cmath import exp
from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.reactive.synthesis import DegreeOfFreedom, Utilitor, motion, superpose, synthesise

responses = st.floats(-1, 1)
utilities = st.floats(0, 1)
utilitors = st.builds(Utilitor.normalised, responses, utilities)
many = st.lists(utilitors, min_size=1, max_size=8)


@given(many)
def test_superposition_is_eqs_2_and_3(competing: list[Utilitor]) -> None:
    resultant = sum(one.u * exp(1j * one.r) for one in competing)
    got = superpose(competing)
    assert got.u == pytest.approx(abs(resultant) / len(competing), abs=1e-8)
    assert got.u * len(competing) * exp(1j * got.r) == pytest.approx(resultant, abs=1e-8)


@given(many)
def test_superposition_does_not_depend_on_order(competing: list[Utilitor]) -> None:
    shuffled = sorted(competing, key=lambda one: (one.u, one.r))
    one, other = superpose(competing), superpose(shuffled)
    assert one.u == pytest.approx(other.u, abs=1e-9)
    if one.u > 1e-6:
        assert one.r == pytest.approx(other.r, abs=1e-5)


@given(responses, utilities)
def test_opposing_responses_of_equal_utility_cancel(response: float, utility: float) -> None:
    got = superpose([Utilitor.normalised(response, utility), Utilitor.normalised(-response, utility)])
    assert got.r == pytest.approx(0, abs=1e-6)


@given(many)
def test_resultant_is_bounded_by_the_responses_and_their_mean_utility(competing: list[Utilitor]) -> None:
    got = superpose(competing)
    assert got.u <= sum(one.u for one in competing) / len(competing) + 1e-9
    if got.u > 1e-6:
        assert min(one.r for one in competing) - 1e-6 <= got.r <= max(one.r for one in competing) + 1e-6


@given(many, st.integers(2, 4))
def test_repeating_every_utilitor_changes_nothing(competing: list[Utilitor], times: int) -> None:
    one, other = superpose(competing), superpose(competing * times)
    assert other.u == pytest.approx(one.u, abs=1e-8)


@given(many, st.integers(1, 5))
def test_indifferent_utilitors_scale_the_utility_by_m_and_leave_the_response(
    competing: list[Utilitor], idle: int
) -> None:
    one, other = superpose(competing), superpose(competing + [Utilitor(0, 0)] * idle)
    assert other.u == pytest.approx(one.u * len(competing) / (len(competing) + idle), abs=1e-8)
    assert other.r == pytest.approx(one.r, abs=1e-6)


@given(responses, st.floats(0.01, 1))
def test_a_single_utilitor_is_returned_unchanged(response: float, utility: float) -> None:
    one = Utilitor.normalised(response, utility)
    got = superpose([one])
    assert (got.r, got.u) == (pytest.approx(one.r), pytest.approx(one.u))


def test_nothing_to_superpose_is_an_error() -> None:
    with pytest.raises(ValueError, match="at least 1"):
        superpose([])


def test_no_resultant_is_no_motion() -> None:
    assert superpose([Utilitor(pi, 0.4), Utilitor(0, 0.4)]) == Utilitor(0, 0)


def test_translate_and_rotate_are_resolved_separately() -> None:
    competing = {
        DegreeOfFreedom.TRANSLATE: [Utilitor.normalised(1, 1)],
        DegreeOfFreedom.ROTATE: [Utilitor.normalised(-0.5, 1)],
    }
    driven = motion(synthesise(competing), speed_m_s=0.4, turn_rad_s=2)
    assert (driven.linear_m_s, driven.angular_rad_s) == (pytest.approx(0.4), pytest.approx(-1))
    assert driven.close_gripper is None


@pytest.mark.parametrize(("response", "closes"), [(1, True), (-1, False), (0, None)])
def test_grip_closes_opens_or_leaves_the_gripper(response: float, closes: bool | None) -> None:
    resultant = synthesise({DegreeOfFreedom.GRIP: [Utilitor.normalised(response, 1)]})
    assert motion(resultant, speed_m_s=1, turn_rad_s=1).close_gripper is closes
