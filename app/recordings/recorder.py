"""Records every mission under way, from its beginning to its end; begins another part after a restart."""

import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from app.agents import RobotBoard
from app.core import Core
from app.domain.lifecycles.mission import ENDED
from app.recordings.concordance import Concordance
from app.recordings.mcap_writer import GOAL, MISSION, PLAN, SCRIPT, WORLD
from app.recordings.recording_store import RecordingStore
from app.recordings.replay import last_event
from app.recordings.story import Chapter, Story, names_in, told
from app.recordings.track import Track
from app.store import EventRow, GoalRow, MissionRow, ScriptRow, is_unavailable
from app.workflows.background import Background
from app.workflows.leases import ExecutorRegistry
from robots.clock import Clock

LOOK_S = 0.5
PAUSE_S = 0.1
LONGEST_EVENTS = 500
FULL_S = 60.0
"""How long a disk that takes no more is left alone."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Shown:
    """How the API shows what is recorded; given by the composition root, for the API is not ours to import."""

    goal: Callable[[GoalRow], dict[str, Any]]
    mission: Callable[[MissionRow, Sequence[ScriptRow]], dict[str, Any]]
    plan: Callable[[str], dict[str, Any]]
    world: Callable[[str], dict[str, Any]]
    samples: Callable[[str], dict[str, str]]
    places: Callable[[str], dict[str, tuple[float, float]]]


class Recorder:
    """Writes what is told of missions onto tapes, in a thread of its own."""

    def __init__(
        self,
        core: Core,
        *,
        shelf: RecordingStore,
        board: RobotBoard,
        clocks: Mapping[str, Clock],
        shown: Shown,
        presence: ExecutorRegistry,
    ) -> None:
        """:param presence: holds the leases of the worlds that this process records."""
        self._events, self._story = core.events, Story(core.database)
        self._board, self._shelf = board, shelf
        self._concordance = Concordance(clocks)
        self._shown, self._speaks = shown, presence.holds_lease
        self._tracks: dict[str, Track] = {}
        self._seen = 0
        self._looked_at = -1
        self._background = Background("recorder", self._run)

    def start(self) -> None:
        if self._shelf.takes_nothing:
            return
        self._seen = self._events.last()
        self._background.start()

    def close(self) -> None:
        self._background.ending.set()
        self._board.wake()
        if not self._background.end():
            return
        self._let_go()

    def _let_go(self) -> None:
        while self._tracks:
            with suppress(OSError):
                self._tracks.popitem()[1].writer.close()

    def _run(self) -> None:
        generation, begun = 0, False
        while not self._background.ending.is_set():
            try:
                if not begun:
                    self._under_way()
                    begun = True
                generation = self._board.wait(generation, LOOK_S)
                self._concordance.read()
                self._look()
                self._hear()
                self._end()
                if self._shelf.is_to_be_tidied:
                    self._shelf.make_room(spare=frozenset(self._tracks))
            except OSError as error:
                logger.warning("nothing is recorded for %.0f s: %s", FULL_S, error)
                self._let_go()
                self._background.ending.wait(FULL_S)
            except Exception as error:
                if is_unavailable(error):
                    logger.warning("recordings wait for the database")
                else:
                    logger.exception("something could not be recorded")
                self._background.ending.wait(LOOK_S)
            self._background.ending.wait(PAUSE_S)

    def _look(self) -> None:
        """What the record says anew: missions that begin, change and end, and the events of each."""
        if self._events.generation == self._looked_at:
            return
        self._looked_at = self._events.generation
        rows = self._events.since(self._seen, LONGEST_EVENTS)
        if len(rows) == LONGEST_EVENTS:
            self._looked_at = -1
        if not rows:
            return
        about = [(row, names_in(row)) for row in rows]
        concerned = set[str]().union(*(names | self._of(names) for _, names in about))
        for chapter in self._chapters(concerned):
            self._record(chapter, before=rows[0].seq)
        self._tell(about)
        self._seen = rows[-1].seq

    def _of(self, names: frozenset[str]) -> set[str]:
        """The recorded missions that any of the names is about."""
        return {mission for mission, track in self._tracks.items() if not names.isdisjoint(track.names)}

    def _tell(self, about: Sequence[tuple[EventRow, frozenset[str]]]) -> None:
        moved = set()
        for row, names in about:
            for track in (self._tracks[one] for one in self._of(names)):
                track.event(told(row), self._concordance.at_s(track.world, row.time))
            if row.type == "world.facts_changed":
                moved.add(row.subject)
        for world in moved & {track.world for track in self._tracks.values()}:
            samples = self._shown.samples(world)
            for track in self._tracks.values():
                if track.world == world:
                    track.lie(samples, self._concordance.now_s(world))

    def _chapters(self, ids: Collection[str]) -> list[Chapter]:
        """Of those of the missions that are for us to record; not what was recorded before."""
        missions = self._story.missions(ids)
        return self._story.chapters(
            [one for one in missions if self._speaks(one.world) and self._is_wanted(one)]
        )

    def _is_wanted(self, mission: MissionRow) -> bool:
        # One that waits costs nothing: it is recorded from when its first robot has begun.
        begun = mission.started_at_s is not None
        fresh = mission.state not in ENDED or not self._shelf.has(mission.id)
        return mission.id in self._tracks or (begun and fresh)

    def _under_way(self) -> None:
        """Go on with what an earlier process recorded."""
        for chapter in self._chapters(self._story.under_way()):
            self._record(chapter, before=self._seen + 1)

    def _record(self, chapter: Chapter, *, before: int) -> None:
        """:param before: events from this number on are still to be told."""
        mission = chapter.mission
        track = self._tracks.get(mission.id) or self._begin(chapter, before)
        track.robots = frozenset(script.robot for script in chapter.scripts)
        track.names = frozenset((mission.id, mission.goal_id, mission.world, *chapter.plans, *track.robots))
        now_s = self._concordance.now_s(mission.world)
        track.stands(GOAL, self._shown.goal(chapter.goal), now_s)
        for plan in chapter.plans:
            if not track.knows(PLAN, plan):
                track.stands(PLAN, self._shown.plan(plan), now_s)
        for script in chapter.scripts:
            track.stands(SCRIPT, script.body, now_s)
        track.stands(MISSION, self._shown.mission(mission, chapter.scripts), now_s)

    def _begin(self, chapter: Chapter, before: int) -> Track:
        """Another part; first on it is what happened since the goal was stated and is on no part yet."""
        mission, world = chapter.mission, chapter.mission.world
        earlier = last_event(self._shelf.entries(mission.id)) if self._shelf.has(mission.id) else 0
        track = Track(mission.id, self._shelf.begin(mission.id), world, self._shown.places(world))
        self._tracks[mission.id] = track
        for row in self._story.events(chapter, after=earlier, before=before):
            track.event(told(row), self._concordance.at_s(world, row.time))
        now_s = self._concordance.now_s(world)
        track.writer.tell(WORLD, self._shown.world(world), now_s)
        track.lie(self._shown.samples(world), now_s)
        return track

    def _hear(self) -> None:
        """Where the robots are now."""
        views = self._board.views() if self._tracks else {}
        for track in self._tracks.values():
            track.hear(views)

    def _end(self) -> None:
        for mission_id in [one.mission for one in self._tracks.values() if one.is_over]:
            self._tracks.pop(mission_id).writer.close()
            logger.info("recorded %s", mission_id)
