"""Where the view puts things, without a browser."""

from math import atan, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.world import ZoneRule, load_world
from web.api_types import Fact, Layout, Plan, PlannedAction, RobotTelemetry, Wall
from web.scene import palette
from web.scene.building import wall_pieces
from web.scene.camera import BACK, FOV_RAD, MAX_SHARE, ROTATION, CameraView, distance_m
from web.scene.frame import RADIUS_M, range_segments
from web.scene.geometry import Mesh, box, cylinder, merged, segments, turned
from web.scene.labels import (
    LETTER_PX,
    LINE_PX,
    ROBOT_RANK,
    SELECTED_RANK,
    FloorLabel,
    Label,
    covered,
    without_overlap,
)
from web.scene.paths import routes
from web.scene.peripherals import panels_of
from web.scene.robots import label_text
from web.scene.samples import LIFTED_M, SamplePositions

LAYOUT = Layout.model_validate(
    {
        "compartments": [{"name": "yard", "x": [0, 8], "y": [0, 3]}],
        "locations": [
            {"name": "door_1", "kind": "door", "at": [2, 0.4]},
            {"name": "bay_1", "kind": "bay", "at": [0.5, 2]},
        ],
        "samples": [{"name": "sample_1", "at": "door_1"}],
    }
)
AT_DOOR, IN_BAY, IN_ROBOT = (
    Fact(predicate="in", args=("sample_1", ref)) for ref in ("door_1", "bay_1", "yard_1")
)


def told(**changes: object) -> RobotTelemetry:
    return RobotTelemetry.model_validate({"x_m": 1.0, "y_m": 1.0, "heading_rad": 0.0} | changes)


def place(places: SamplePositions, fact: Fact, **changes: object) -> tuple[float, float, float] | None:
    return places.update([fact], {"yard_1": told(**changes)}).get("sample_1")


def test_every_rule_of_a_zone_has_a_colour_of_its_own_in_both_themes() -> None:
    for theme in (palette.LIGHT, palette.DARK):
        assert set(theme.zones) == set(ZoneRule)
        assert len(set(theme.zones.values())) == len(ZoneRule)


def test_a_sample_lies_where_the_facts_say() -> None:
    assert place(SamplePositions(LAYOUT), AT_DOOR) == (2.0, 0.4, 0.0)


def test_a_sample_that_a_robot_says_it_holds_is_at_its_jaws_whatever_the_facts_say() -> None:
    assert place(SamplePositions(LAYOUT), AT_DOOR, holding="sample_1") == pytest.approx((1.34, 1.0, LIFTED_M))


def test_a_sample_just_released_stays_there_until_the_facts_change() -> None:
    places = SamplePositions(LAYOUT)
    place(places, AT_DOOR, holding="sample_1")
    assert place(places, AT_DOOR, x_m=0.2) == pytest.approx((1.34, 1.0, 0.0))
    assert place(places, IN_BAY) == (0.5, 2.0, 0.0)


def test_facts_that_know_of_the_release_before_the_telemetry_are_believed() -> None:
    places = SamplePositions(LAYOUT)
    place(places, AT_DOOR, holding="sample_1")
    place(places, IN_ROBOT, holding="sample_1")
    place(places, IN_BAY, holding="sample_1")
    assert place(places, IN_BAY) == (0.5, 2.0, 0.0)


def test_a_sample_that_is_with_a_robot_which_does_not_hold_it_lies_where_its_tag_was_seen() -> None:
    seen = {"sample_1": (3.0, 2.0)}
    assert place(SamplePositions(LAYOUT), IN_ROBOT, tags=seen) == (3.0, 2.0, 0.0)


def test_a_sample_of_which_nothing_is_known_is_not_drawn() -> None:
    assert SamplePositions(LAYOUT).update([], {}) == {}


def test_a_door_is_drawn_open_by_its_fact_and_a_lift_by_its_level() -> None:
    layout = Layout.model_validate(load_world("guarded_store").model_dump(mode="json"))
    panels = panels_of(layout)
    assert panels[Fact(predicate="opened", args=("gate_1",))] == ((5.5, 5.7), (5.5, 6.9))
    assert panels[Fact(predicate="lift_at", args=("lift_1", "upper"))] == ((12.4, 5.7), (12.4, 6.9))
    assert len(panels) == 5


def test_a_wall_is_cut_at_its_openings() -> None:
    wall = Wall.model_validate(
        {
            "start": [0, 0],
            "end": [8, 0],
            "openings": [
                {"kind": "door", "at_m": 2, "width_m": 1},
                {"kind": "gap", "at_m": 7.5, "width_m": 1},
            ],
        }
    )
    assert wall_pieces(wall) == [
        ("wall", 0.0, 1.5),
        ("door", 1.5, 2.5),
        ("wall", 2.5, 7.0),
        ("gap", 7.0, 8.0),
    ]


def test_the_second_of_four_whiskers_points_to_the_left() -> None:
    points, colours = range_segments([told(heading_rad=pi / 2, ranges_m=[None, 1.5, None, None])])
    left = points[2]  # after the one that keeps the node from being empty
    np.testing.assert_allclose(left[:, :2], [[1 - RADIUS_M, 1], [1 - 1.5, 1]], atol=1e-6)
    assert tuple(colours[2][1]) == palette.WHISKER_HIT
    assert points.shape == colours.shape == (5, 2, 3)


def test_the_whiskers_keep_their_count_whatever_they_meet() -> None:
    free, hit = ([told(ranges_m=ranges)] for ranges in ([None] * 16, [0.5] * 16))
    assert range_segments(free)[0].shape == range_segments(hit)[0].shape


def test_a_label_tells_the_active_packet_or_that_the_robot_is_not_heard() -> None:
    assert label_text("yard_1", told(at_s=10.0), 10.1) == "yard_1"
    assert label_text("yard_1", told(at_s=10.0, packet_tag="DOCK"), 10.1) == "yard_1: DOCK"
    assert label_text("yard_1", told(at_s=10.0, packet_tag="DOCK"), 16.0) == "yard_1 (not heard)"


@pytest.mark.parametrize(
    "mesh", [box((1, 2, 3)), cylinder(0.5, 0.0, 1.0), cylinder(0.5, 0.0, 1.0, top_radius_m=0.2)]
)
def test_meshes_are_closed_and_face_outwards(mesh: Mesh) -> None:
    vertices, faces = mesh
    corners = vertices[faces].astype(np.float64)
    edges = {(a, b) for face in faces.tolist() for a, b in zip(face, face[1:] + face[:1], strict=True)}
    assert all((b, a) in edges for a, b in edges)
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume > 0


def test_merged_meshes_keep_their_own_faces() -> None:
    one, other = box(), box(centre=(5.0, 0.0, 0.0))
    vertices, faces = merged([one, other])
    assert len(vertices) == 16
    assert vertices[faces[12:]].min(axis=(0, 1))[0] == pytest.approx(4.5)


@given(st.floats(-10, 10))
def test_a_turn_takes_the_eastward_axis_to_the_heading(heading_rad: float) -> None:
    w, x, y, z = turned([heading_rad])[0].astype(float)
    assert (x, y) == (0, 0)
    np.testing.assert_allclose(
        [w * w - z * z, 2 * w * z], [np.cos(heading_rad), np.sin(heading_rad)], atol=1e-5
    )


def test_instances_get_the_linear_light_of_their_colour() -> None:
    assert palette.batched([(0, 128, 255)]).tolist() == [[0, 55, 255]]


def test_a_long_sample_lies_across_its_place_and_hangs_between_who_hold_it() -> None:
    places = SamplePositions(
        Layout.model_validate(
            {
                "compartments": [{"name": "lab", "x": [0, 8], "y": [0, 3]}],
                "locations": [{"name": "quarry", "kind": "place", "at": [2, 1], "approach_deg": [180]}],
                "samples": [{"name": "beam", "at": "quarry", "length_m": 0.9}],
            }
        )
    )
    at_quarry = Fact(predicate="in", args=("beam", "quarry"))
    assert places.update([at_quarry], {})["beam"] == (2.0, 1.0, 0.0)
    assert places.heading_rad("beam", {}) == pytest.approx(3 * pi / 2)
    seen = [(3.34, 1.44), (3.34, 1.46)]
    pair = {
        name: told(x_m=3.0, y_m=y_m, heading_rad=0.1, holding="beam", tags={"beam": at})
        for name, y_m, at in zip(("fred", "ginger"), (1.9, 1.0), seen, strict=True)
    }
    assert places.update([at_quarry], pair)["beam"] == pytest.approx((3.34, 1.45, LIFTED_M))
    assert places.heading_rad("beam", pair) == pytest.approx(0.1 + pi / 2)


def view(**changes: float) -> CameraView:
    """Ten metres above the origin, looking straight down, north up; 100 pixels a metre on the floor."""
    sizes = {"fov_rad": 2 * atan(0.3), "width_px": 800.0, "height_px": 600.0} | changes
    return CameraView(position=np.array([0.0, 0.0, 10.0]), rotation=np.diag([1.0, -1.0, -1.0]), **sizes)


def test_a_camera_sees_what_is_below_it_in_the_middle_and_north_above() -> None:
    seen = view().project(np.array([(0.0, 0.0, 0.0), (1.0, 2.0, 0.0)]))
    np.testing.assert_allclose(seen, [(400, 300, 10), (500, 100, 10)])


def labels(*spots: tuple[str, float, int]) -> list[Label]:
    return [Label(name=name, text=name, at=(x_m, 0.0, 0.0), rank=rank) for name, x_m, rank in spots]


def test_of_labels_on_one_spot_the_chosen_one_is_shown() -> None:
    near_by = labels(
        ("robot_a", 0.0, ROBOT_RANK), ("sample_b", 0.1, SELECTED_RANK), ("robot_c", 2.0, ROBOT_RANK)
    )
    assert {label.name for label in without_overlap(near_by, view())} == {"sample_b", "robot_c"}


def test_what_is_beside_the_picture_or_behind_the_camera_has_no_label() -> None:
    assert without_overlap(labels(("far", 9.0, SELECTED_RANK)), view()) == []
    behind = Label(name="behind", text="behind", at=(0.0, 0.0, 11.0), rank=SELECTED_RANK)
    assert without_overlap([behind], view()) == []


@pytest.mark.parametrize(
    ("at", "hidden"),
    [((0.0, 0.1), True), ((0.0, -0.1), False), ((0.45, 0.1), True), ((0.5, 0.1), False), ((0.0, 0.5), False)],
)
def test_a_place_is_not_named_where_the_name_of_a_robot_is(at: tuple[float, float], hidden: bool) -> None:
    # "robot" takes 20 pixels to either side and 20 up; "bay_7", in letters of 0.17 m, 28 to either side and 24 down.
    robot = labels(("robot", 0.0, ROBOT_RANK))
    place = FloorLabel(name="bay_7", text="bay_7", at=(*at, 0.0), letters_m=0.17)
    assert covered([place], robot, view()) == [hidden]
    assert covered([place], [], view()) == [False]


@given(st.lists(st.tuples(st.floats(-4, 4), st.floats(-3, 3)), max_size=80))
def test_labels_never_overlap(spots: list[tuple[float, float]]) -> None:
    crowd = [Label(name=str(i), text="robot", at=(*spot, 0.0), rank=1) for i, spot in enumerate(spots)]
    shown = view().project(
        np.array([label.at for label in without_overlap(crowd, view())] or np.zeros((0, 3)))
    )
    for i, one in enumerate(shown):
        for other in shown[i + 1 :]:
            assert abs(one[0] - other[0]) >= 5 * LETTER_PX or abs(one[1] - other[1]) >= LINE_PX
    assert bool(len(shown)) == bool(spots)


@pytest.mark.parametrize("size", [(400.0, 900.0), (800.0, 600.0), (1800.0, 400.0)])
def test_the_whole_world_fills_the_picture_and_no_more(size: tuple[float, float]) -> None:
    corners = np.array([(x, y, 0.0) for x in (-4.0, 4.0) for y in (-3.0, 3.0)])
    away = distance_m(corners, *size)
    seen = CameraView(
        position=away * BACK, rotation=ROTATION, fov_rad=FOV_RAD, width_px=size[0], height_px=size[1]
    ).project(corners)
    filled = np.abs(seen[:, :2] / size - 0.5).max()
    assert filled == pytest.approx(MAX_SHARE / 2, abs=0.01)


def test_a_plan_takes_each_robot_from_place_to_place() -> None:
    actions = [
        ("a3", "TRANSPORT", 2.0, {"ref1": "door_1", "ref2": "bay_1"}),
        ("a1", "NAVIGATE", 0.0, {"ref1": "home_1", "ref2": "door_1", "area": "yard"}),
        ("a2", "DOCK", 1.0, {"object": "sample_1", "ref1": "door_1"}),
    ]
    plan = Plan(
        id="p",
        actions=tuple(
            PlannedAction(id=id_, agents=("yard_1",), arguments=arguments, earliest_start_s=start_s)
            for id_, _, start_s, arguments in actions
        ),
    )
    door, bay = (2.0, 0.4), (0.5, 2.0)
    # Home is no place of this layout: the first leg is the one from the door.
    assert routes(plan, LAYOUT) == {"yard_1": [("a3", door, bay)]}


def test_going_back_in_a_recording_forgets_who_held_what() -> None:
    places = SamplePositions(LAYOUT)
    place(places, AT_DOOR, holding="sample_1")
    places.forget()
    assert place(places, AT_DOOR) == (2.0, 0.4, 0.0)


def test_polylines_become_segments_that_do_not_join_one_line_with_the_next() -> None:
    lines = [
        ([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], (1, 2, 3)),
        ([(9.0, 9.0)], (0, 0, 9)),
        ([(5.0, 5.0), (6.0, 5.0)], (7, 8, 9)),
    ]
    points, colours = segments(lines, 0.5)
    assert points[1:].tolist() == [
        [[0.0, 0.0, 0.5], [1.0, 0.0, 0.5]],
        [[1.0, 0.0, 0.5], [1.0, 1.0, 0.5]],
        [[5.0, 5.0, 0.5], [6.0, 5.0, 0.5]],
    ]
    assert colours[1:, :, 0].tolist() == [[1, 1], [1, 1], [7, 7]]
    assert points[0, 0, 2] < 0


def test_without_polylines_a_hidden_segment_is_left() -> None:
    points, colours = segments([], 0.5)
    assert points.shape == colours.shape == (1, 2, 3)
