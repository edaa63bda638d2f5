"""What packets bring beside their effects: images, taken once and only when asked for, and readings."""

import pytest
from pydantic import ValidationError

from robots.errors import RepertoireError
from robots.physical.body import Image, Pose
from robots.physical.profile import ALL_SENSORS, Architecture
from robots.repertoire import Repertoire, load_repertoire
from robots.wire import (
    MAX_IMAGE_BYTES,
    FailureCategory,
    ImageResult,
    Message,
    PacketReport,
    PacketState,
    ReadingResult,
    ScriptState,
)
from tests.robots.stories import EAST, Service, packet, room, run, script

PNG = b"\x89PNG\r\n\x1a\n and what follows"
LOOK = """
tag: LOOK
about: Looks at a place.
arguments: [ref]
places: [ref]
patterns:
  - name: rest
    dof: translate
    level: task
    stimulus: {sense: always}
    r: {form: constant, value: 0}
    u: {form: constant, value: 1}
after: [{sense: elapsed, s: 0.5}]
"""
RESULTS = "results: [{image: camera, of: $ref}, {reading: light_lx, unit: lx, of: $ref}]"


def repertoire(results: str = RESULTS) -> Repertoire:
    return load_repertoire([("look.yaml", LOOK + results)])


def looking(
    data: bytes | None = PNG,
    *,
    media_type: str = "image/png",
    results: str = RESULTS,
    architecture: Architecture = Architecture.PARALLEL,
) -> Service:
    """A robot that has carried out LOOK, with a camera that takes these bytes; None: that takes none."""
    world = room()
    link = world.add(
        "fred",
        Pose(x_m=3, y_m=1.2, heading_rad=EAST),
        packets=repertoire(results),
        repertoire=("LOOK",),
        sensors=ALL_SENSORS | {"camera"},
        architecture=architecture,
    )
    body = world.bodies["fred"]
    body.measured = {"light_lx": 412.0}
    if data is not None:
        body.cameras = {"camera": Image(media_type=media_type, data=data)}
    service = Service(world, link, "fred")
    service.order(script("fred", packet("LOOK", ref="yard")))
    assert run(world, [service], lambda: service.report is not None, limit_s=20)
    return service


def finished(service: Service) -> list[PacketReport]:
    reports = (message.body for message in service.heard)
    return [one for one in reports if isinstance(one, PacketReport) and one.state is PacketState.FINISHED]


@pytest.mark.parametrize("architecture", Architecture)
def test_a_packets_results_are_in_the_report_of_its_end(architecture: Architecture) -> None:
    service = looking(architecture=architecture)
    report, *others = finished(service)
    assert not others
    assert report.results == (
        ImageResult(name="camera", of="yard", media_type="image/png", data=PNG),
        ReadingResult(name="light_lx", of="yard", value=412.0, unit="lx"),
    )


def test_a_camera_runs_only_while_its_image_is_taken() -> None:
    service = looking()
    ticks = [one.sensors for one in service.telemetry]
    assert service.world.bodies["fred"].images_taken == 1
    assert ["camera" in running for running in ticks].count(True) <= 1


def failure(service: Service) -> str:
    assert service.report is not None
    assert (service.report.state, service.report.category) == (ScriptState.FAILED, FailureCategory.ROBOT)
    return service.report.detail


def test_a_camera_that_takes_no_image_fails_the_script_by_name() -> None:
    assert "camera reads nothing" in failure(looking(None))


def test_an_image_that_is_too_large_to_be_sent_fails_the_packet_with_both_sizes() -> None:
    said = failure(looking(PNG.ljust(MAX_IMAGE_BYTES + 1)))
    assert "the image of camera has 524,289 bytes, at most 524,288 can be sent" in said


def test_an_image_that_is_not_of_its_media_type_fails_the_packet() -> None:
    assert "not those of image/jpeg" in failure(looking(media_type="image/jpeg"))
    assert "media_type" in failure(looking(media_type="image/svg+xml"))


def test_a_quantity_that_is_not_measured_fails_the_packet_with_those_that_are() -> None:
    said = failure(looking(results="results: [{reading: dust, of: $ref}]"))
    assert "fred does not measure dust; it measures light_lx" in said


def test_a_script_whose_images_no_camera_can_take_is_refused() -> None:
    world = room()
    link = world.add(
        "fred", Pose(x_m=3, y_m=1.2, heading_rad=EAST), packets=repertoire(), repertoire=("LOOK",)
    )
    service = Service(world, link, "fred")
    service.order(script("fred", packet("LOOK", ref="yard")))
    assert run(world, [service], lambda: bool(service.heard), limit_s=5)
    assert "fred has no camera" in str(service.heard[0].body)


@pytest.mark.parametrize(
    ("results", "words"),
    [
        ("results: [{image: camera}]", "results.0.of: Field required"),
        ("results: [{image: camera, reading: light_lx, of: $ref}]", "either an image"),
        ("results: [{of: $ref}]", "either an image"),
        ("results: [{image: camera, unit: px, of: $ref}]", "an image has none"),
        ("results: [{image: camera, of: $place}]", "$place is not an argument"),
    ],
)
def test_a_faulty_slot_is_named(results: str, words: str) -> None:
    with pytest.raises(RepertoireError) as refused:
        repertoire(results)
    assert words in str(refused.value)
    assert "line 14" in str(refused.value)


def test_results_travel_as_json() -> None:
    report = finished(looking())[0]
    message = Message(performative="inform", sender="fred", receiver="service", sent_at_s=1.0, body=report)
    assert Message.model_validate_json(message.model_dump_json()) == message


@pytest.mark.parametrize("data", ["no base64!", "", "R0lGODlh"])
def test_data_that_are_no_image_are_refused(data: str) -> None:
    with pytest.raises(ValidationError):
        ImageResult.model_validate({"name": "camera", "of": "yard", "media_type": "image/png", "data": data})
