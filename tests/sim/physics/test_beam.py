"""The compliant capture heads: how a long object hangs on them, and when a handle slips out."""

from cmath import rect
from math import pi, remainder, tau

import pytest

from sim.physics.beam import MAX_TORQUE_N_M, STIFFNESS_N_M, TRAVEL_M, Beam, Contact, JawsPose

STEP_S = 1 / 60
LENGTH_M = 0.9
LEFT, RIGHT = JawsPose(0.45j, 0.0), JawsPose(-0.45j, 0.0)


def beam_of(*, left: bool = True, right: bool = True) -> Beam:
    """An object across the x axis, fred's jaws at its left handle, ginger's at its right one."""
    beam = Beam(LENGTH_M, 0j, pi / 2)
    if left:
        beam.grip("fred", 1, LEFT)
    if right:
        beam.grip("ginger", -1, RIGHT)
    return beam


def run(beam: Beam, seconds: float, presses: tuple[Contact, ...] = (), **jaws: JawsPose) -> list[str]:
    """Hold the jaws where they are for a while; who has lost its handle by the end."""
    lost: list[str] = []
    for _ in range(round(seconds * 60)):
        lost = beam.advance(jaws, presses, STEP_S)
    return lost


def moved(jaws: JawsPose, by: complex) -> JawsPose:
    return JawsPose(jaws.middle + by, jaws.heading_rad)


def test_an_object_at_rest_on_both_heads_stays_there() -> None:
    beam = beam_of()
    run(beam, 2, fred=LEFT, ginger=RIGHT)
    assert abs(beam.middle) < 1e-9
    assert abs(beam.deflection("fred")) < 1e-9


def test_a_force_deflects_the_heads_by_its_size_over_their_stiffness() -> None:
    beam = beam_of()
    force_n = 2.0
    press = Contact(0j, 1 + 0j, force_n / 5000.0)
    run(beam, 3, (press,), fred=LEFT, ginger=RIGHT)
    for rover in ("fred", "ginger"):
        assert beam.deflection(rover) == pytest.approx(force_n / 2 / STIFFNESS_N_M, rel=0.02)


def test_a_head_exerts_on_its_robot_what_the_object_has_of_it() -> None:
    """Jaws 0.02 m too far out each: the object pulls both robots towards its middle, with the spring's force."""
    beam = beam_of()
    run(beam, 2, fred=moved(LEFT, 0.02j), ginger=moved(RIGHT, -0.02j))
    pull_n = 0.02 * STIFFNESS_N_M
    assert beam.load("fred").force_n == pytest.approx(-1j * pull_n, abs=0.05)
    assert beam.load("ginger").force_n == pytest.approx(1j * pull_n, abs=0.05)
    assert beam.load("fred").torque_n_m == pytest.approx(0.0, abs=0.05)


def test_a_load_is_in_the_robots_own_frame() -> None:
    facing_north = JawsPose(0.45j, pi / 2)
    beam = Beam(LENGTH_M, 0j, pi / 2)
    beam.grip("fred", 1, facing_north)
    beam.grip("ginger", -1, RIGHT)
    run(beam, 2, fred=moved(facing_north, 0.02j), ginger=moved(RIGHT, -0.02j))
    assert beam.load("fred").force_n == pytest.approx(-0.02 * STIFFNESS_N_M, abs=0.05)


def test_robots_too_far_apart_feel_the_object_between_them() -> None:
    beam = beam_of()
    run(beam, 2, fred=moved(LEFT, 0.02j), ginger=moved(RIGHT, -0.02j))
    assert beam.deflection("fred") == pytest.approx(-0.02j, abs=1e-4)
    assert beam.deflection("ginger") == pytest.approx(0.02j, abs=1e-4)


def test_a_robot_that_runs_ahead_is_held_back_and_the_other_pulled_on() -> None:
    beam = beam_of()
    run(beam, 3, fred=moved(LEFT, 0.06), ginger=RIGHT)
    assert beam.deflection("fred").real < -0.005
    assert beam.deflection("ginger").real > 0.005


def test_what_has_been_let_loose_comes_to_rest_within_a_second() -> None:
    beam = beam_of()
    run(beam, 2, fred=moved(LEFT, 0.05), ginger=moved(RIGHT, 0.05))
    run(beam, 1, fred=LEFT, ginger=RIGHT)
    assert abs(beam.deflection("fred")) < 1e-3
    before = beam.middle
    run(beam, STEP_S, fred=LEFT, ginger=RIGHT)
    assert abs(beam.middle - before) < 1e-4


def test_a_handle_slips_out_beyond_the_heads_travel_and_not_before() -> None:
    inside, beyond = (1j * (2 * TRAVEL_M + by) for by in (-0.01, 0.01))
    beam = beam_of()
    assert run(beam, 2, fred=moved(LEFT, inside), ginger=RIGHT) == []
    assert set(run(beam, 2, fred=moved(LEFT, beyond), ginger=RIGHT)) == {"fred", "ginger"}


def test_jaws_slip_round_on_the_handle_when_the_torque_is_too_high() -> None:
    beam = beam_of()
    for tick in range(1, 241):
        turned = 0.2 * tick * STEP_S
        jaws = {"fred": JawsPose(LEFT.middle, turned), "ginger": JawsPose(RIGHT.middle, turned)}
        beam.advance(jaws, (), STEP_S)
    most_m = 2 * MAX_TORQUE_N_M / LENGTH_M / STIFFNESS_N_M
    assert abs(beam.deflection("fred")) == pytest.approx(most_m, rel=0.05)


def test_one_head_alone_carries_the_object_along_as_it_turns() -> None:
    beam = beam_of(right=False)
    for tick in range(1, 241):
        turned = 0.5 * tick * STEP_S
        beam.advance({"fred": JawsPose(0.45j, turned)}, (), STEP_S)
    run(beam, 2, fred=JawsPose(0.45j, turned))
    assert remainder(beam.heading_rad - pi / 2 - turned, tau) == pytest.approx(0, abs=0.02)
    assert beam.handle(1) == pytest.approx(0.45j, abs=0.01)
    assert beam.middle == pytest.approx(0.45j - rect(LENGTH_M / 2, pi / 2 + turned), abs=0.02)
