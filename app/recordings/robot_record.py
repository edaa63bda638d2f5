"""What one robot perceived during a recorded mission, as far as its telemetry says, for rules to be tried on.

Recorded are pose, whiskers, samples in view, touches, what is held, and battery; neither beacons nor robots in view. Of
robots with rules, messages are recorded that nothing but rules may take.
"""

import json
from cmath import phase
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, radians
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from app.domain.errors import Invalid, NotFound
from app.recordings.mcap_writer import EVENTS, MINDS, ROBOTS, SCRIPT, WORLD
from app.recordings.recording_store import entries_of
from robots.contract.known_scripts import ENDED
from robots.deliberative.reader import beliefs_of
from robots.deliberative.rehearsal import RecordedInstant
from robots.deliberative.situation import Task
from robots.deliberative.terms import Term
from robots.deliberative.vocabulary import MESSAGE
from robots.errors import RuleError
from robots.perception.fusion import Perception
from robots.perception.sensing import MutualDataStore
from robots.physical.body import Gripper, Pose, Readings, Sensor
from robots.physical.geometry import to_robot
from robots.physical.profile import BeaconSpec, RobotProfile
from robots.physical.sightings import Sighting, Sightings
from robots.wire import OWN, MindReport, Telemetry, ToldMessage


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotRecord:
    """:param home: the place of the robot's charger, if it has one. :param instants: at each telemetry, in order.

    :param has_touches: its bumper's readings are recorded. :param has_messages: what was said to it is.
    :param unread_messages: how many of these are cut off, or are nothing that rules can write.
    """

    home: str | None
    instants: Sequence[RecordedInstant]
    has_touches: bool
    has_messages: bool
    unread_messages: int


@dataclass(slots=True)
class _Record:
    """What a file says of the robot."""

    layout: Mapping[str, Any] = field(default_factory=dict)
    telemetry: list[Telemetry] = field(default_factory=list)
    tasks: dict[str, Task] = field(default_factory=dict)
    raised: list[tuple[float, str, str]] = field(default_factory=list)
    robots: set[str] = field(default_factory=set)
    heard: dict[ToldMessage, None] | None = None
    """In the order of their time; None: no mind has told of messages."""


def robot_record(file: Path, robot: str) -> RobotRecord:
    """The instants at which the robot's whole telemetry was recorded.

    :raises NotFound: if the file does not exist.
    :raises Invalid: if it holds no whole telemetry of the robot; names those of which it does.
    """
    if not file.is_file():
        raise NotFound(f"no recording {file}")
    record = _read(file, robot)
    if not record.telemetry:
        raise Invalid(
            f"{file} is no recording of a mission of {robot}: only its own robots' telemetry is recorded whole",
            choices=sorted(record.robots),
        )
    profile = _profile(record, robot, record.telemetry[0])
    began_s = record.telemetry[0].at_s
    heard = [one for one in record.heard or () if one.at_s >= began_s]
    messages = sorted(((one.at_s, term) for one in heard if (term := _message(one))), key=itemgetter(0))
    return RobotRecord(
        home=profile.home,
        instants=list(_instants(record, profile, messages)),
        has_touches=any(one.touched is not None for one in record.telemetry),
        has_messages=record.heard is not None,
        unread_messages=len(heard) - len(messages),
    )


def _read(file: Path, robot: str) -> _Record:
    record = _Record()
    events: list[Mapping[str, Any]] = []
    for _, channel, message in entries_of(file):
        if channel.message_encoding != "json":
            continue
        body = json.loads(message.data)
        if channel.topic.startswith(ROBOTS) and "battery" in body:
            name = channel.topic.removeprefix(ROBOTS)
            record.robots.add(name)
            if name == robot:
                record.telemetry.append(Telemetry.model_validate(body))
        elif channel.topic == MINDS + robot and (told := MindReport.model_validate(body)).heard is not None:
            record.heard = {**(record.heard or {}), **dict.fromkeys(told.heard)}
        elif channel.topic == WORLD:
            record.layout = body.get("layout") or {}
        elif channel.topic == SCRIPT and body.get("robot") == robot:
            record.tasks |= {
                one["id"]: Task(tag=one["tag"], arguments=one.get("arguments") or {})
                for one in body.get("packets", ())
            }
        elif channel.topic == EVENTS:
            events.append(body.get("data") or {})
    for data in events:
        if data.get("robot") == robot and data.get("packet") in record.tasks:
            at_s = float(data.get("at_s") or 0.0)
            record.raised += [
                (at_s, record.tasks[data["packet"]].tag, one) for one in data.get("events") or ()
            ]
    record.telemetry.sort(key=lambda one: one.at_s)
    record.raised.sort()
    return record


def _instants(
    record: _Record, profile: RobotProfile, messages: Sequence[tuple[float, Term]]
) -> Iterator[RecordedInstant]:
    perception = Perception(profile)
    raised = deque(record.raised)
    said = deque(messages)
    before: Telemetry | None = None
    for told in record.telemetry:
        news: list[tuple[str, str]] = []
        while raised and raised[0][0] <= told.at_s:
            news.append(raised.popleft()[1:])
        heard: list[Term] = []
        while said and said[0][0] <= told.at_s:
            heard.append(said.popleft()[1])
        percepts = perception.perceive(
            MutualDataStore(_sensed(told)),
            _pose(told),
            told.at_s,
            battery=told.battery,
            charging=told.charging,
        )
        yield RecordedInstant(
            percepts=percepts,
            raised=news,
            packets=_new_packet(before, told),
            scripts=_new_script(before, told),
            task=_task(record, told),
            heard=heard,
        )
        before = told


def _message(told: ToldMessage) -> Term | None:
    """As rules believe it; None if its content is cut off, or is nothing that rules can write."""
    try:
        (content,) = beliefs_of([f"said({told.content})"])
    except RuleError:
        return None
    return Term(MESSAGE, (told.performative, told.sender, *content.args))


def _task(record: _Record, told: Telemetry) -> Task | None:
    """The packet of the service's script; None without one."""
    if told.script_id is None or told.script_state in ENDED or told.script_id.startswith(OWN):
        return None
    return record.tasks.get(told.packet_id or "", Task(tag=told.packet_tag or ""))


def _profile(record: _Record, robot: str, first: Telemetry) -> RobotProfile:
    places = {
        place["name"]: BeaconSpec(
            x_m=place["at"][0],
            y_m=place["at"][1],
            approach_rad=tuple(radians(axis) for axis in place.get("approach_deg") or ()),
        )
        for place in record.layout.get("locations") or ()
    }
    homes = {one["name"]: one.get("home") for one in record.layout.get("robots") or ()}
    others = tuple(sorted(homes.keys() - {robot}))
    return RobotProfile(name=robot, start=_pose(first), beacons=places, others=others, home=homes.get(robot))


def _sensed(told: Telemetry) -> dict[str, object]:
    """The readings of the sensors that ran; a bumper of which nothing is told was not touched."""
    running = set(told.sensors)
    tags = [_sighting(told, name, at) for name, at in told.tags.items()]
    readings = Readings(
        time_s=told.at_s,
        ranges_m=np.array([inf if one is None else one for one in told.ranges_m])
        if told.ranges_m and Sensor.ULTRASONIC in running
        else None,
        bumper=bool(told.touched),
        sightings=Sightings.of(tags) if Sensor.INFRA_RED in running else None,
        gripper=Gripper(closed=told.holding is not None, between_jaws=told.holding),
        capture_head_m=None,
    )
    return readings.by_sensor()


def _sighting(told: Telemetry, name: str, at: tuple[float, float]) -> Sighting:
    seen = to_robot(_pose(told), complex(*at))
    return Sighting(identity=name, range_m=abs(seen), bearing_rad=phase(seen))


def _pose(told: Telemetry) -> Pose:
    return Pose(x_m=told.x_m, y_m=told.y_m, heading_rad=told.heading_rad)


def _new_packet(before: Telemetry | None, told: Telemetry) -> Sequence[tuple[str, str]]:
    """The packet's new state; a packet that is followed by another one has finished."""
    if before is not None and before.packet_id == told.packet_id and before.packet_state == told.packet_state:
        return []
    news = []
    is_followed = before is not None and before.packet_id != told.packet_id and told.packet_id is not None
    if before is not None and is_followed and before.packet_tag and before.script_id == told.script_id:
        news.append((before.packet_tag, "finished"))
    if told.packet_tag and told.packet_state:
        news.append((told.packet_tag, told.packet_state.value))
    return news


def _new_script(before: Telemetry | None, told: Telemetry) -> Sequence[str]:
    is_new = before is None or (before.script_id, before.script_state) != (told.script_id, told.script_state)
    return [told.script_state.value] if is_new and told.script_state in ENDED else []
