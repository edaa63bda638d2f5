"""A recording in the form that a page replays: rows of poses, other telemetry, states and events."""

import json
from base64 import b64encode
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage

from app.recordings.mcap_writer import (
    BRIEF_FIELDS,
    EVENTS,
    GOAL,
    IMAGES,
    MINDS,
    MISSION,
    NANO,
    NUMBERS,
    PLAN,
    RESULTS,
    ROBOTS,
    SAMPLES,
    SCRIPT,
    WORLD,
)
from app.recordings.recording_store import Entry

POSE_INTERVAL_S = 0.2
"""Poses closer in time than this are left out."""
TELEMETRY_INTERVAL_S = 1.0
"""Other telemetry closer in time than this is left out."""


@dataclass(slots=True)
class Replay:
    """What happened, on the world's clock.

    `robots`: by name, rows of `[at_s, x_m, y_m, heading_rad, holding, packet_tag]`; `telemetry`: by name, the other
    telemetry of the mission's own robots; `minds`: what those with rules believed and were committed to, each from its
    `at_s` on. `missions`: the mission's states, each from `at_s` on; `goal`: its last
    state; `plans`: all plans made for it, and `scripts`: the robots' scripts, by id; `samples`: the samples' believed
    places, each from `at_s` on; `numbers`: the values of the world's numeric facts, likewise; `results`: what packets
    brought, images with their content as a `data:` address in `image`; `events`: all events, in order.
    """

    world: dict[str, Any] = field(default_factory=dict)
    goal: dict[str, Any] = field(default_factory=dict)
    robots: dict[str, list[list[Any]]] = field(default_factory=dict)
    telemetry: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    minds: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    missions: list[dict[str, Any]] = field(default_factory=list)
    plans: dict[str, Any] = field(default_factory=dict)
    scripts: dict[str, Any] = field(default_factory=dict)
    samples: list[dict[str, Any]] = field(default_factory=list)
    numbers: list[dict[str, Any]] = field(default_factory=list)
    results: list[dict[str, Any]] = field(default_factory=list)
    events: list[dict[str, Any]] = field(default_factory=list)


def replay_of(entries: Iterable[Entry]) -> Replay:
    replay = Replay()
    by_id = {PLAN: replay.plans, SCRIPT: replay.scripts}
    results: dict[str, dict[str, Any]] = {}  # a process that goes on after a killed one may repeat the last
    result: dict[str, Any] = {}
    for topic, body, at_s in _entries(entries):
        if topic.startswith(ROBOTS):
            _add_robot(replay, topic.removeprefix(ROBOTS), body, at_s)
        elif topic.startswith(MINDS):
            replay.minds.setdefault(topic.removeprefix(MINDS), []).append(body)
        elif topic == EVENTS:
            replay.events.append({"at_s": at_s, **body})
        elif topic == MISSION:
            replay.missions.append({"at_s": at_s, "mission": body})
        elif topic == SAMPLES:
            replay.samples.append({"at_s": at_s, "lying": body})
        elif topic == NUMBERS:
            replay.numbers.append({"at_s": at_s, "values": body})
        elif topic == RESULTS:
            result = results[body["id"]] = {**body, "at_s": at_s}
        elif topic.startswith(IMAGES):  # follows its result
            result["image"] = f"data:{result['media_type']};base64,{b64encode(body).decode()}"
        elif topic in by_id:
            by_id[topic][body["id"]] = body
        elif topic == GOAL:
            replay.goal = body
        elif topic == WORLD:
            replay.world = body
    replay.results.extend(results.values())
    return replay


def last_event(entries: Iterable[Entry]) -> int:
    """The number of the newest event in a recording; 0 without one."""
    return max((body["seq"] for topic, body, _ in _entries(entries) if topic == EVENTS), default=0)


def _entries(entries: Iterable[Entry]) -> Iterable[tuple[str, Any, float]]:
    """Topic, body and time of what is recorded as JSON, and of images."""
    for _, channel, message in entries:
        at_s = message.log_time / NANO
        if channel.message_encoding == "json":
            yield channel.topic, json.loads(message.data), at_s
        elif channel.topic.startswith(IMAGES):
            yield channel.topic, CompressedImage.FromString(message.data).data, at_s


def _add_robot(replay: Replay, name: str, said: dict[str, Any], at_s: float) -> None:
    rows = replay.robots.setdefault(name, [])
    if rows and at_s - rows[-1][0] < POSE_INTERVAL_S - 0.01:  # tolerate one tick
        return
    place = [round(said["x_m"], 3), round(said["y_m"], 3), round(said["heading_rad"], 3)]
    rows.append([round(at_s, 2), *place, said["holding"], said["packet_tag"]])
    telemetry = replay.telemetry.setdefault(name, []) if said.keys() > BRIEF_FIELDS else None
    if telemetry is not None and (
        not telemetry or at_s - telemetry[-1]["at_s"] >= TELEMETRY_INTERVAL_S - 0.01
    ):
        telemetry.append({key: value for key, value in said.items() if key not in BRIEF_FIELDS})
