"""What each of two robots that carry a long object makes of what it senses."""

from cmath import phase, rect
from math import pi

import pytest

from robots.conditions.composition import unmet
from robots.conditions.long_objects import AtHandle, HoldsAlone, JointNear, LinedUp, Over
from robots.perception.formation import formation_with
from robots.perception.percepts import Percepts
from robots.physical.body import GRIPPER_REACH_M, RADIUS_M, Readings
from robots.physical.sightings import Sighting
from robots.reactive.carrying import Askew, JointWayOn, JointWayRound, PutAhead, PutAside
from robots.repertoire import load_repertoire
from tests.robots.sensed import PROFILE, percepts, readings, sees, watch
from tests.robots.stories import packet

HALF_M = 0.45


def beam(middle: complex, turned_rad: float = 0.0) -> Sighting:
    """The long object's tag at a point of the robot's frame; square to the robot, or turned."""
    return sees("beam", abs(middle), phase(middle), phase(middle) - turned_rad)


def robot(at: complex) -> Sighting:
    return sees("other", abs(at), phase(at))


def bay(at: complex) -> Sighting:
    """The beacon of a bay that emits straight at the robot's side of the world."""
    return sees("bay", abs(at), phase(at), phase(at))


def held(side: int, turned_rad: float = 0.0, *others: Sighting) -> Percepts:
    """Holds the handle of the object whose middle is to the left (1) or right (-1)."""
    middle = GRIPPER_REACH_M + side * 1j * rect(HALF_M, turned_rad)
    return percepts(beam(middle, turned_rad), *others, closed=True, between="beam")


@pytest.mark.parametrize("side", [1, -1])
def test_the_partner_stands_on_the_other_side_of_the_middle(side: int) -> None:
    whole = formation_with(held(side), "beam")
    assert whole is not None
    assert whole.middle == pytest.approx(side * 1j * HALF_M)
    assert whole.partner == pytest.approx(side * 1j * 2 * HALF_M)
    assert whole.offset_m == pytest.approx(-side * HALF_M)
    assert whole.radius_m == HALF_M + RADIUS_M


def test_a_robot_without_the_object_in_its_jaws_is_in_no_formation() -> None:
    assert formation_with(percepts(beam(1 + 0j)), "beam") is None


@pytest.mark.parametrize("turned_rad", [-0.3, 0.3])
def test_a_robot_that_is_not_square_to_the_object_turns_to_be(turned_rad: float) -> None:
    assert Askew(object="beam", full_rad=0.6).read(held(1, turned_rad)) == pytest.approx(turned_rad / 0.6)


def test_straight_ahead_both_go_at_the_same_speed() -> None:
    for side in (1, -1):
        ahead = bay(3.0 + side * 1j * HALF_M)
        on = JointWayOn(object="beam", place="bay").read(held(side, 0.0, ahead))
        assert on == pytest.approx(0.5, abs=0.02)


def test_in_a_bend_the_robot_on_the_outside_goes_faster() -> None:
    speeds = {}
    for side in (1, -1):
        to_the_left = bay(3.0 + 3.0j + side * 1j * HALF_M)
        now = held(side, 0.0, to_the_left)
        speeds[side] = JointWayOn(object="beam", place="bay").read(now)
        turn = JointWayRound(object="beam", place="bay").read(now)
        assert turn is not None
        assert turn > 0
    # the object is to the left of who stands on the right
    assert speeds[1] is not None
    assert speeds[-1] is not None
    assert speeds[1] > speeds[-1] + 0.3


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(("bearing_rad", "way"), [(2.2, 1), (-2.2, -1), (2.6, 1), (-2.6, 1)])
def test_both_robots_turn_to_the_left_for_a_place_behind_them_on_either_side(
    side: int, bearing_rad: float, way: int
) -> None:
    place = bay(side * 1j * HALF_M + rect(3.0, bearing_rad))
    turn = JointWayRound(object="beam", place="bay").read(held(side, 0.0, place))
    assert turn is not None
    assert way * turn > 0


def test_the_partner_is_no_obstacle_and_a_rock_between_is_one() -> None:
    """The rock is narrow and straight ahead of the middle: one robot alone would pass it on its own course."""
    ahead = bay(3.0 + 1j * HALF_M)
    free = held(1, 0.0, ahead, robot(2j * HALF_M))
    assert JointWayRound(object="beam", place="bay").read(free) == pytest.approx(0.0, abs=0.02)
    middle = GRIPPER_REACH_M + 1j * HALF_M
    blocked = percepts(
        beam(middle), ahead, robot(2j * HALF_M), closed=True, between="beam", whiskers={1: 0.8}
    )
    assert abs(JointWayRound(object="beam", place="bay").read(blocked) or 0.0) > 0.05


def test_the_whole_has_arrived_when_its_middle_stands_before_the_place() -> None:
    there = bay(0.8 + 1j * HALF_M)
    assert JointNear(object="beam", place="bay").check(held(1, 0.0, there)).holds
    not_yet = bay(1.4 + 1j * HALF_M)
    verdict = JointNear(object="beam", place="bay").check(held(1, 0.0, not_yet))
    assert not verdict.holds
    assert "has beam 0.60 m short of bay" in verdict.words


def test_another_robot_is_at_a_handle_when_its_jaws_are_and_it_stands() -> None:
    handle = GRIPPER_REACH_M + 2j * HALF_M
    at_it = held(1, 0.0, robot(handle - GRIPPER_REACH_M))
    assert AtHandle(object="beam", robot="other", still_s=0.5).check(at_it).holds
    assert not AtHandle(object="beam", robot="other", still_s=5).check(at_it).holds
    off = held(1, 0.0, robot(handle - 0.8))
    assert (
        AtHandle(object="beam", robot="other").check(off).words == "sees other 0.80 m from a handle of beam"
    )


def test_who_still_creeps_up_to_the_other_handle_is_waited_for() -> None:
    """The last of the way is driven at 0.03 m/s: for seconds by less than what counts as having moved."""
    wanted = packet("TRANSPORT", object="beam", ref2="bay", partner="other", awaits=["in(beam, other)"])
    before = load_repertoire().bind(wanted, PROFILE).before

    def instant(short_m: float) -> Readings:
        partner = robot(2j * HALF_M - short_m)
        return readings(beam(GRIPPER_REACH_M + 1j * HALF_M), partner, closed=True, between="beam")

    creeps = [instant(0.1 - 0.03 * tick / 20) for tick in range(60)]
    assert AtHandle(object="beam", robot="other").check(watch(creeps)).holds
    assert unmet(before, watch(creeps))
    stands = [instant(0.01)] * 60
    assert not unmet(before, watch([*creeps, *stands]))


def test_a_robot_holds_alone_once_the_other_has_backed_off() -> None:
    handle = GRIPPER_REACH_M + 2j * HALF_M
    assert not HoldsAlone(object="beam").check(held(1, 0.0, robot(handle - GRIPPER_REACH_M))).holds
    assert HoldsAlone(object="beam").check(held(1, 0.0, robot(handle - 0.85))).holds


@pytest.mark.parametrize(("aside_m", "lined_up"), [(0.0, True), (0.09, True), (0.2, False)])
def test_a_robot_is_lined_up_within_a_funnel_before_a_handle(aside_m: float, lined_up: bool) -> None:
    left_ahead = percepts(beam(0.8 - 1j * HALF_M + 1j * aside_m))
    assert LinedUp(target="beam@left").check(left_ahead).holds is lined_up


def test_a_robot_beyond_the_object_is_not_lined_up_with_it() -> None:
    """Else it would grip face to face with the other."""
    aligned = percepts(beam(0.5 + 1j * HALF_M), robot(0.5 + 2j * HALF_M + GRIPPER_REACH_M))
    assert aligned.locate("beam@free") == pytest.approx(0.5)
    assert not LinedUp(target="beam@free").check(aligned).holds


def test_the_free_handle_is_the_left_one_unless_another_robot_stands_at_it() -> None:
    middle = 1.2 + 0j
    assert percepts(beam(middle)).locate("beam@free") == pytest.approx(1.2 + 1j * HALF_M)
    taken = percepts(beam(middle), robot(1.2 - GRIPPER_REACH_M + 1j * HALF_M))
    assert taken.locate("beam@free") == pytest.approx(1.2 - 1j * HALF_M)


def test_a_long_object_is_gripped_from_the_side_on_which_another_robot_stands_at_it() -> None:
    alone = percepts(beam(1.2 + 0j))
    assert alone.axis("beam@free") == pytest.approx(pi)
    beyond = percepts(beam(1.2 + 0j), robot(1.2 + GRIPPER_REACH_M + 1j * HALF_M))
    assert beyond.axis("beam@free") == pytest.approx(0.0)
    assert beyond.locate("beam@free") == pytest.approx(1.2 - 1j * HALF_M)
    assert beyond.approach_point("beam@free") == pytest.approx(2.0 - 1j * HALF_M)


def test_the_object_is_put_down_where_its_middle_is_over_the_place() -> None:
    middle = GRIPPER_REACH_M + 1j * HALF_M
    over = held(1, 0.0, bay(middle))
    assert Over(object="beam", place="bay").check(over).holds
    short = held(1, 0.0, bay(middle + 0.2))
    assert not Over(object="beam", place="bay").check(short).holds
    assert PutAhead(object="beam", place="bay").read(short) == pytest.approx(0.5, abs=0.02)
    assert PutAside(object="beam", place="bay").read(short) == pytest.approx(0.0, abs=0.02)
