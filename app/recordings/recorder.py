"""Records every mission from its beginning to its end; each restart of the service begins another part (file)."""

import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from app.agents import RobotBoard
from app.core import Core
from app.domain.events import FactsChanged, NumbersChanged, ResultReceived, WorldChanged
from app.domain.lifecycles.mission import ENDED
from app.recordings.clock_map import ClockMap
from app.recordings.mcap_writer import GOAL, MISSION, PLAN, SCRIPT, WORLD
from app.recordings.mind_sampler import MindSampler
from app.recordings.mission_reader import MissionReader, MissionRecord, names_in
from app.recordings.mission_recording import MissionRecording
from app.recordings.recording_store import RecordingStore
from app.recordings.replay import last_event
from app.store import EventRow, GoalRow, MissionRow, ResultRow, ScriptRow, is_unavailable
from app.store.event_log import envelope
from app.workflows.background import Background
from app.workflows.leases import ExecutorRegistry
from robots.clock import Clock

INTERVAL_S = 0.5
"""Longest wait for new telemetry, and the pause after an error."""
PAUSE_S = 0.1
"""Least time between two turns: telemetry is recorded at most ten times a second."""
MAX_EVENTS = 500
"""Events read from the database at once."""
DISK_FULL_PAUSE_S = 60.0
"""Pause after a write has failed, such as on a full disk."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedBodies:
    """Functions that return what is recorded in the API's form, injected since recordings cannot import the API.

    :param samples: the believed place or robot of each sample of a world.
    :param numbers: the value of each numeric fact of a world, by `battery(rover_1)`.
    :param places: x and y in metres of each place of a world.
    """

    goal: Callable[[GoalRow], dict[str, Any]]
    mission: Callable[[MissionRow, Sequence[ScriptRow]], dict[str, Any]]
    plan: Callable[[str], dict[str, Any]]
    result: Callable[[ResultRow], dict[str, Any]]
    world: Callable[[str], dict[str, Any]]
    samples: Callable[[str], dict[str, str]]
    numbers: Callable[[str], dict[str, float]]
    places: Callable[[str], dict[str, tuple[float, float]]]


class Recorder:
    """Writes recordings in a thread of its own."""

    def __init__(
        self,
        core: Core,
        *,
        recordings: RecordingStore,
        board: RobotBoard,
        clocks: Mapping[str, Clock],
        bodies: RecordedBodies,
        executors: ExecutorRegistry,
        minds: MindSampler,
    ) -> None:
        """:param executors: this process records the worlds that it drives; other processes record the others."""
        self._events = core.events
        self._missions = MissionReader(core.database)
        self._board = board
        self._recordings = recordings
        self._clock_map = ClockMap(clocks)
        self._bodies = bodies
        self._minds = minds
        self._drives = executors.holds_lease
        self._open: dict[str, MissionRecording] = {}
        self._last_seq = 0
        self._generation = -1
        self._background = Background("recorder", self._run)

    def start(self) -> None:
        if self._recordings.is_disabled:
            return
        self._last_seq = self._events.last()
        self._background.start()

    def close(self) -> None:
        self._background.ending.set()
        self._board.wake()
        if not self._background.end():
            return
        self._close_all()

    def _close_all(self) -> None:
        while self._open:
            with suppress(OSError):
                self._open.popitem()[1].writer.close()

    def _run(self) -> None:
        generation = 0
        resumed = False
        while not self._background.ending.is_set():
            try:
                if not resumed:
                    self._resume()
                    resumed = True
                generation = self._board.wait(generation, INTERVAL_S)
                self._clock_map.read()
                self._record_events()
                self._record_robots()
                self._record_minds()
                self._close_ended()
                if self._recordings.is_measurement_due:
                    self._recordings.delete_oldest(keep=frozenset(self._open))
            except OSError as error:
                logger.warning(
                    "recordings cannot be written, next attempt in %.0f s: %s", DISK_FULL_PAUSE_S, error
                )
                self._close_all()
                self._background.ending.wait(DISK_FULL_PAUSE_S)
            except Exception as error:
                if is_unavailable(error):
                    logger.warning("recording paused: database unavailable")
                else:
                    logger.exception("recording failed")
                self._background.ending.wait(INTERVAL_S)
            self._background.ending.wait(PAUSE_S)

    def _record_events(self) -> None:
        """Record the new events in the database, and the missions that they concern."""
        if self._events.generation == self._generation:
            return
        self._generation = self._events.generation
        rows = self._events.since(self._last_seq, MAX_EVENTS)
        if len(rows) == MAX_EVENTS:
            self._generation = -1
        if not rows:
            return
        about = [(row, names_in(row)) for row in rows]
        concerned = set[str]().union(*(names | self._recorded(names) for _, names in about))
        for record in self._records(concerned):
            self._record(record, before=rows[0].seq)
        self._write_events(about)
        self._last_seq = rows[-1].seq

    def _recorded(self, names: frozenset[str]) -> set[str]:
        """The missions being recorded that any of the names belongs to."""
        return {mission for mission, recording in self._open.items() if not names.isdisjoint(recording.names)}

    def _write_events(self, about: Sequence[tuple[EventRow, frozenset[str]]]) -> None:
        moved = set()
        counted = set()
        for row, names in about:
            for recording in (self._open[one] for one in self._recorded(names)):
                self._write_event(recording, row)
            if row.type == FactsChanged.TYPE:
                moved.add(row.subject)
            elif row.type == NumbersChanged.TYPE:
                counted.add(row.subject)
            elif row.type == WorldChanged.TYPE:
                self._write_world(row.subject)
            elif row.type.startswith("rules."):
                self._minds.rules_changed(row.subject)
        open_worlds = {one.world for one in self._open.values()}
        for world in filter(self._clock_map.knows, counted & open_worlds):
            numbers = self._bodies.numbers(world)
            for recording in self._open.values():
                if recording.world == world:
                    recording.write_numbers(numbers, self._clock_map.now_s(world))
        for world in filter(self._clock_map.knows, moved & open_worlds):
            samples = self._bodies.samples(world)
            for recording in self._open.values():
                if recording.world == world:
                    recording.write_samples(samples, self._clock_map.now_s(world))

    def _write_world(self, world: str) -> None:
        """Write a changed world; a replay shows the last one."""
        changed = [one for one in self._open.values() if one.world == world and self._clock_map.knows(world)]
        body = self._bodies.world(world) if changed else None
        for recording in changed:
            recording.places = self._bodies.places(world)
            recording.writer.write_json(WORLD, body, self._clock_map.now_s(world))

    def _write_event(self, recording: MissionRecording, row: EventRow) -> None:
        """Write an event, after the result that it tells of: a killed process's successor goes on after the last event
        that was written.
        """
        result = self._missions.result(row.data["result"]) if row.type == ResultReceived.TYPE else None
        if result is not None:
            recording.writer.write_result(self._bodies.result(result), result.content, result.at_s)
        recording.write_event(envelope(row), self._clock_map.at_s(recording.world, row.time))

    def _records(self, ids: Collection[str]) -> list[MissionRecord]:
        """The records of those missions that this process has to record."""
        missions = self._missions.missions(ids)
        return self._missions.records([one for one in missions if self._is_wanted(one)])

    def _is_wanted(self, mission: MissionRow) -> bool:
        if not self._clock_map.knows(mission.world):
            return mission.id in self._open  # its world was removed before its last events were written
        if not self._drives(mission.world):
            return False
        if mission.id in self._open:
            return True
        # A recording begins when the mission's first robot starts.
        begun = mission.started_at_s is not None
        return begun and (mission.state not in ENDED or not self._recordings.has(mission.id))

    def _resume(self) -> None:
        """Begin another part of the recordings that an earlier process left open."""
        for record in self._records(self._missions.open_missions()):
            self._record(record, before=self._last_seq + 1)

    def _record(self, record: MissionRecord, *, before: int) -> None:
        """:param before: events from this number on are written later."""
        mission = record.mission
        recording = self._open.get(mission.id) or self._begin(record, before)
        recording.robots = frozenset(script.robot for script in record.scripts)
        recording.names = frozenset(
            (mission.id, mission.goal_id, mission.world, *record.plans, *recording.robots)
        )
        now_s = self._clock_map.now_s(mission.world)
        recording.write_state(GOAL, self._bodies.goal(record.goal), now_s)
        for plan in record.plans:
            if not recording.has_written(PLAN, plan):
                recording.write_state(PLAN, self._bodies.plan(plan), now_s)
        for script in record.scripts:
            recording.write_state(SCRIPT, script.body, now_s)
        recording.write_state(MISSION, self._bodies.mission(mission, record.scripts), now_s)

    def _begin(self, record: MissionRecord, before: int) -> MissionRecording:
        """Begin another part with the events since the goal was submitted that no earlier part holds."""
        mission = record.mission
        world = mission.world
        earlier = last_event(self._recordings.entries(mission.id)) if self._recordings.has(mission.id) else 0
        recording = MissionRecording(
            mission.id, self._recordings.new_part(mission.id), world, self._bodies.places(world)
        )
        self._open[mission.id] = recording
        for row in self._missions.events(record, after=earlier, before=before):
            self._write_event(recording, row)
        now_s = self._clock_map.now_s(world)
        recording.writer.write_json(WORLD, self._bodies.world(world), now_s)
        recording.write_samples(self._bodies.samples(world), now_s)
        recording.write_numbers(self._bodies.numbers(world), now_s)
        return recording

    def _record_robots(self) -> None:
        """Record the robots' telemetry."""
        views = self._board.views() if self._open else {}
        for recording in self._open.values():
            recording.write_robots(views)

    def _record_minds(self) -> None:
        """Record what robots believe and are committed to."""
        robots = frozenset[str]().union(*(one.robots for one in self._open.values()))
        for name, report in self._minds.reports(robots):
            for recording in self._open.values():
                if name in recording.robots:
                    recording.write_mind(name, report)

    def _close_ended(self) -> None:
        for mission_id in [one.mission for one in self._open.values() if one.is_over]:
            self._open.pop(mission_id).writer.close()
            logger.info("recording of mission %s is complete", mission_id)
