"""The file of settings: defaults, frames, places, and errors that say where."""

import json
from cmath import rect
from math import hypot, pi, radians
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.adapters.vda5050.factsheets import repertoire, robot_factsheet, robot_name
from robots.adapters.vda5050.frame import Frame
from robots.adapters.vda5050.messages import VehicleFactsheet
from robots.adapters.vda5050.settings import APPROACH_M, Settings, SettingsError, load_settings, place_at
from robots.adapters.vda5050.topics import VehicleId
from robots.physical.stand_off import STAND_OFF_M
from robots.world import shipped_worlds
from tests.robots.adapters.vda5050.driven import ERRAND, SETTINGS, Driven

VEHICLE = VehicleId(manufacturer="ACME", serial_number="AGV-7.x")
metres = st.floats(-1e3, 1e3)


@given(
    offset=st.tuples(metres, metres),
    rotation_deg=st.floats(-720, 720),
    scale=st.floats(0.1, 10),
    x=metres,
    y=metres,
    heading=st.floats(-pi + 0.01, pi - 0.01),
)
def test_a_pose_is_found_again_on_the_way_back(
    offset: tuple[float, float], rotation_deg: float, scale: float, x: float, y: float, heading: float
) -> None:
    frame = Frame(offset=offset, rotation_deg=rotation_deg, scale=scale)
    back = frame.in_world(frame.on_map((x, y, heading)))
    assert hypot(back[0] - x, back[1] - y) < 1e-6
    assert abs(back[2] - heading) < 1e-9


def test_a_map_is_scaled_turned_and_shifted() -> None:
    frame = Frame(offset=(10.0, 20.0), rotation_deg=90.0, scale=2.0)
    assert frame.on_map((1.0, 0.0, 0.0)) == pytest.approx((10.0, 22.0, pi / 2))


def test_a_map_with_another_frame_is_driven_to_the_same_places_of_the_world() -> None:
    frame = Frame(map_id="default", offset=(5.0, -1.0), rotation_deg=90.0)
    driven = Driven(settings=SETTINGS.model_copy(update={"frame": frame}))
    driven.vehicle.x, driven.vehicle.y = 5.0, -1.0
    driven.carry_out(ERRAND)
    assert (driven.vehicle.x, driven.vehicle.y) == pytest.approx((2.0, 1.0))  # the world's (2, 3)
    told = driven.driver.telemetry()
    assert told is not None
    assert (told.x_m, told.y_m) == pytest.approx((2.0, 3.0))


def test_without_a_file_vehicles_are_called_by_their_serial_numbers() -> None:
    settings = load_settings(None)
    assert robot_name(VEHICLE, settings) == "agv_7_x"
    assert robot_name(VehicleId(manufacturer="A", serial_number="007"), settings) == "vehicle_007"


def test_places_of_a_world_file_are_where_its_robots_stand_before_them() -> None:
    assert APPROACH_M == STAND_OFF_M
    settings = load_settings(None, world_file=shipped_worlds()["sample_store"])
    assert settings.places["bay_1"].pose()[:2] == pytest.approx((1.3, 5.2))
    hatch = settings.places["interchange_1"]
    assert hatch.pose(near=(2.0, 1.0))[:2] == pytest.approx((2.0, 2.8))
    assert hatch.pose(near=(2.0, 8.0))[:2] == pytest.approx((2.0, 4.4))


@pytest.mark.parametrize("approach_deg", [0.0, 45.0, 90.0, 180.0, 200.0, 270.0, -90.0, 359.0])
def test_a_vehicle_before_a_place_faces_it(approach_deg: float) -> None:
    place = place_at((3.0, 4.0), [approach_deg]).pose()
    away = rect(APPROACH_M, radians(approach_deg))
    assert complex(place.x, place.y) == pytest.approx(3.0 + 4.0j + away, abs=1e-6)
    assert place.heading_rad is not None
    assert rect(APPROACH_M, place.heading_rad) == pytest.approx(-away, abs=1e-6)
    assert -pi < place.heading_rad <= pi


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("frame: {scale: 0}", "line 1, frame.scale: Input should be greater than 0"),
        ("frames: {}", "line 1, frames: Extra inputs are not permitted"),
        ("versions: [1]", "choices: 2, 3"),
        ("vehicles: {AGV: {}}", "'AGV' is not of the form manufacturer/serial number"),
        ("vehicles: {A/1: {robot: x}, A/2: {robot: x}}", "two of them are called x"),
        ("- a", "does not contain a mapping"),
        ("a: [", "cannot be read"),
        ("world_file: nowhere.yaml", "nowhere.yaml cannot be read"),
    ],
)
def test_settings_that_do_not_fit_are_refused_with_their_place(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "vda5050.yaml"
    path.write_text(text)
    with pytest.raises(SettingsError) as error:
        load_settings(path)
    assert said in str(error.value)


def test_the_published_json_schema_is_that_of_the_settings() -> None:
    published = json.loads(Path("docs/vda5050.schema.json").read_text())
    assert published == Settings.model_json_schema()


def test_an_empty_file_is_the_defaults(tmp_path: Path) -> None:
    path = tmp_path / "vda5050.yaml"
    path.write_text("")
    assert load_settings(path) == Settings()


def test_a_vehicle_has_the_packets_whose_actions_it_supports() -> None:
    settings = Settings()
    full = Driven().vehicle.factsheet()
    features = full.protocol_features.mobile_robot_actions
    without_drop = full.protocol_features.model_copy(
        update={"mobile_robot_actions": tuple(one for one in features if one.action_type != "drop")}
    )
    assert set(repertoire(full, VEHICLE, settings)) == {"NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2"}
    lacking = full.model_copy(update={"protocol_features": without_drop})
    assert set(repertoire(lacking, VEHICLE, settings)) == {"NAVIGATE", "DOCK"}
    assert repertoire(None, VEHICLE, settings) == ("NAVIGATE",)


def test_a_factsheet_says_speed_place_and_that_the_robot_senses_nothing_of_others() -> None:
    sheet = robot_factsheet(Driven().vehicle.factsheet(), VEHICLE, (1.0, 2.0, pi / 2), Settings())
    assert (sheet.speed_m_s, sheet.turn_rad_s) == (0.5, 1.0)
    assert sheet.start == (1.0, 2.0, 90.0)
    assert sheet.senses == ()


def test_a_factsheet_that_says_nothing_leaves_the_settings_word() -> None:
    settings = Settings(speed_m_s=0.3)
    assert not VehicleFactsheet().says_something
    assert robot_factsheet(VehicleFactsheet(), VEHICLE, (0, 0, 0), settings).speed_m_s == 0.3
