"""Writes a mission's recording: an MCAP file (https://mcap.dev) on the world's clock.

Topics: `/tf` (foxglove.FrameTransforms: each robot in the frame `world`, each sample there or in the frame of the robot
that holds it), `/poses/ROBOT` (foxglove.PoseInFrame, of the mission's own robots) and `/images/ROBOT/CAMERA`
(foxglove.CompressedImage), for any viewer of the Foxglove schemas; `/robots/ROBOT` (telemetry; of robots outside the
mission only `BRIEF_FIELDS`), `/minds/ROBOT`, `/events`, `/goal`, `/mission`, `/numbers`, `/plan`, `/results`, `/script`
and `/world` as JSON in the API's form, and `/samples`, the samples' believed places. Log times are the world's clock,
publish times the wall clock; both in nanoseconds.
"""

import json
from collections.abc import Callable, Collection, Mapping
from math import cos, sin
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self, cast

from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from google.protobuf.timestamp_pb2 import Timestamp
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import Writer
from mcap_protobuf.schema import register_schema

from app.domain.clock import SYSTEM_CLOCK, WallClock
from robots.physical.body import GRIPPER_REACH_M
from robots.wire import Telemetry

FRAME = "world"
CHUNK_BYTES = 32 * 1024
"""The most data, uncompressed, that is lost when the process is killed."""
NANO = 1_000_000_000
ROBOTS = "/robots/"
EVENTS = "/events"
GOAL = "/goal"
MINDS = "/minds/"
MISSION = "/mission"
NUMBERS = "/numbers"
PLAN = "/plan"
RESULTS = "/results"
IMAGES = "/images/"
SCRIPT = "/script"
WORLD = "/world"
SAMPLES = "/samples"
TRANSFORMS = "/tf"
POSES = "/poses/"
BRIEF_FIELDS = {"x_m", "y_m", "heading_rad", "holding", "packet_tag"}
"""The recorded telemetry of robots outside the mission."""


class _Appended:
    """A file that is open only during writes: thousands of missions may be recorded at once."""

    def __init__(self, path: Path, wrote: Callable[[int], None]) -> None:
        self._path = path
        self._wrote = wrote
        self._written = 0

    def write(self, data: bytes) -> int:
        with self._path.open("ab") as stream:
            stream.write(data)
        self._written += len(data)
        self._wrote(len(data))
        return len(data)

    def tell(self) -> int:
        return self._written

    def flush(self) -> None: ...


class McapWriter:
    """One file that is being written."""

    def __init__(
        self,
        path: Path,
        *,
        wrote: Callable[[int], None] = lambda size_bytes: None,
        wall: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """:param wrote: called with the number of bytes after each write."""
        self._wall = wall
        self.path = path
        path.touch(exist_ok=False)
        self._writer = Writer(cast(IO[bytes], _Appended(path, wrote)), chunk_size=CHUNK_BYTES)
        self._writer.start(profile="", library="macta")
        self._channels: dict[str, int] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Finish the file with its index, so that readers can seek in it."""
        self._writer.finish()  # type: ignore[no-untyped-call]

    def write_robots(self, telemetry: Mapping[str, Telemetry], *, whole: Collection[str]) -> None:
        """Write telemetry and transforms.

        :param whole: robots whose whole telemetry is kept; of the others only pose, load and packet.
        """
        for name, told in telemetry.items():
            if name in whole:
                self._protobuf(POSES + name, _pose(told), told.at_s)
            kept = told.model_dump_json(exclude={"kind"}, include=None if name in whole else BRIEF_FIELDS)
            self._json(ROBOTS + name, kept, told.at_s)
        if telemetry:
            latest = max(told.at_s for told in telemetry.values())
            transforms = [
                _placed(name, FRAME, told.x_m, told.y_m, told.heading_rad, told.at_s)
                for name, told in telemetry.items()
            ]
            self._protobuf(TRANSFORMS, FrameTransforms(transforms=transforms), latest)

    def write_samples(
        self, held_in: Mapping[str, str], places: Mapping[str, tuple[float, float]], at_s: float
    ) -> None:
        """Write each sample's transform: in its place, or in the gripper of the robot that holds it."""
        transforms = []
        for name, where in held_in.items():
            frame, (x_m, y_m) = (FRAME, places[where]) if where in places else (where, (GRIPPER_REACH_M, 0.0))
            transforms.append(_placed(name, frame, x_m, y_m, 0.0, at_s))
        self._protobuf(TRANSFORMS, FrameTransforms(transforms=transforms), at_s)

    def write_result(self, body: Mapping[str, Any], content: bytes | None, at_s: float) -> None:
        """Write a result as the API has it, and after it its image.

        :param content: an image's; None of a reading.
        """
        self.write_json(RESULTS, body, at_s)
        if content is not None:
            image = CompressedImage(
                timestamp=_stamp(at_s),
                frame_id=body["robot"],
                data=content,
                format=body["media_type"].partition("/")[2],
            )
            self._protobuf(f"{IMAGES}{body['robot']}/{body['name']}", image, at_s)

    def write_json(self, topic: str, body: Any, at_s: float) -> None:
        """Write a body of the API."""
        self._json(topic, json.dumps(body, separators=(",", ":")), at_s)

    def _json(self, topic: str, body: str, at_s: float) -> None:
        channel = self._channels.get(topic)
        if channel is None:
            any_object = json.dumps({"type": "object"}).encode()
            schema = self._writer.register_schema(
                f"macta{topic.replace('/', '.')}", SchemaEncoding.JSONSchema, any_object
            )
            channel = self._channels[topic] = self._writer.register_channel(
                topic, MessageEncoding.JSON, schema
            )
        self._add(channel, body.encode(), at_s)

    def _protobuf(self, topic: str, message: Any, at_s: float) -> None:
        channel = self._channels.get(topic)
        if channel is None:
            schema = register_schema(self._writer, type(message))
            channel = self._channels[topic] = self._writer.register_channel(
                topic, MessageEncoding.Protobuf, schema
            )
        self._add(channel, message.SerializeToString(), at_s)

    def _add(self, channel: int, data: bytes, at_s: float) -> None:
        self._writer.add_message(
            channel, log_time=int(at_s * NANO), data=data, publish_time=int(self._wall.epoch_s() * NANO)
        )


def _placed(name: str, frame: str, x_m: float, y_m: float, heading_rad: float, at_s: float) -> FrameTransform:
    transform = FrameTransform(parent_frame_id=frame, child_frame_id=name, timestamp=_stamp(at_s))
    transform.translation.x = x_m
    transform.translation.y = y_m
    transform.rotation.z = sin(heading_rad / 2)
    transform.rotation.w = cos(heading_rad / 2)
    return transform


def _pose(told: Telemetry) -> PoseInFrame:
    pose = PoseInFrame(frame_id=FRAME, timestamp=_stamp(told.at_s))
    pose.pose.position.x = told.x_m
    pose.pose.position.y = told.y_m
    pose.pose.orientation.z = sin(told.heading_rad / 2)
    pose.pose.orientation.w = cos(told.heading_rad / 2)
    return pose


def _stamp(at_s: float) -> Timestamp:
    return Timestamp(seconds=int(at_s), nanos=int((at_s % 1.0) * NANO))
