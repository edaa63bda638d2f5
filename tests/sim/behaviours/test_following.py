"""FOLLOW_LEFT_OBSTACLE, FOLLOW_RIGHT_OBSTACLE: along a wall at the gap asked, round corners, past openings."""

import pytest

from benchmarks.trial import Trial, packet, room
from robots.physical.body import RADIUS_M
from robots.wire import ScriptState
from robots.world.walls import clearance_m, panels_of

SIDES = [("FOLLOW_RIGHT_OBSTACLE", 0), ("FOLLOW_LEFT_OBSTACLE", 180)]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("tag", "heading"), SIDES)
@pytest.mark.parametrize("gap", [0.3, 0.5])
def test_a_wall_is_followed_at_the_gap_asked(tag: str, heading: float, gap: float, seed: int) -> None:
    world = room(size=(9, 4), start=(2 if heading == 0 else 7, 0.9, heading))
    trial = Trial(world, packet(tag, gap_m=gap, max_distance_m=5), seed=seed)
    gaps: list[float] = []

    def measure() -> None:
        gaps.append(clearance_m((trial.pose.x_m, trial.pose.y_m), panels_of(world.walls)) - RADIUS_M)

    trial.run(each=measure)
    settled = gaps[len(gaps) // 3 :]
    assert max(settled) < gap + 0.15
    assert min(settled) > gap - 0.15
    assert trial.driven_m == pytest.approx(5, abs=0.3)
    assert trial.events == ["wall", "toofar"]
    assert not trial.touched


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("tag", "heading"), SIDES)
@pytest.mark.parametrize("inside", [True, False])
def test_corners_inside_a_room_and_outside_a_box_are_followed(
    tag: str, heading: float, inside: bool, seed: int
) -> None:
    """Once round the room's four corners, or once round a box's."""
    if inside:
        world, way_m = room(size=(4, 4), start=(2, 0.7, heading)), 11
    else:
        world, way_m = room(boxes=[(2.4, 2.4, 3.6, 3.6)], start=(3, 1.8, 180 - heading)), 8
    middle = 2 if inside else 3
    trial = Trial(world, packet(tag, max_distance_m=way_m, timeout_s=80), seed=seed).run()
    assert not trial.touched
    assert "toofar" in trial.events
    assert len({(pose.x_m > middle, pose.y_m > middle) for pose in trial.path}) == 4


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("tag", "heading"), SIDES)
def test_an_opening_in_the_wall_is_an_event_and_can_end_the_packet(
    tag: str, heading: float, seed: int
) -> None:
    boxes = [(0, 0, 3.6, 1.3), (5.0, 0, 9, 1.3)]
    world = room(size=(9, 4), boxes=boxes, start=(1.5 if heading == 0 else 7.5, 1.9, heading))
    trial = Trial(world, packet(tag, until="opening"), seed=seed).run()
    assert trial.ended is not None
    assert trial.ended.state is ScriptState.FINISHED
    assert trial.events == ["wall", "opening"]
    assert 3.2 < trial.pose.x_m < 5.4
