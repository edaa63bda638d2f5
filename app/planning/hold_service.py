"""Holds: places kept empty and facts kept true for some time; begun with a goal, ended by what they wait for."""

import threading
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.clock import SYSTEM_CLOCK, WallClock, iso_utc
from app.domain.errors import Busy, NotFound
from app.domain.events import HoldBegan, HoldEnded
from app.domain.goal_language.hold_checks import comes_true
from app.domain.goal_language.issues import GoalIssue, unknown_name
from app.domain.goal_language.kept_facts import (
    is_kept_true,
    kept_things,
    left_to_keep,
    unknown_in,
)
from app.domain.goal_language.stated_holds import HoldEnd, StatedHold, kept_by, places_in
from app.domain.goal_language.terms import GoalHold
from app.domain.goal_language.words import natural_key
from app.domain.ids import new_id
from app.domain.lifecycles import goal as goal_lifecycle
from app.domain.lifecycles import hold as hold_lifecycle
from app.domain.lifecycles.hold import HoldEnding, HoldState
from app.domain.lifecycles.mission import OPEN
from app.planning.waiting_goals import WaitingGoals
from app.store import GoalRow, HoldRow, MissionRow
from app.store.editions import WorldDirectory
from app.store.event_log import EventLog
from app.store.known_empty import KnownEmpty
from app.store.standing_holds import end_in_words, facts_of, standing_rows
from planner import KnowledgeBaseError
from robots.clock import Clock
from robots.wire import SymbolicFact
from robots.world import WorldFile

MAX_STANDING = 1000
"""The most holds that stand in a world at once."""


@dataclass(slots=True)
class _Watched:
    """What is known of a world's holds since they were last read.

    :param has_changed: something was written since, or they were never read.
    :param next_at: when the first of them ends by the wall clock, seconds since 1970; `next_s`: by the world's clock.
    """

    has_changed: threading.Event = field(default_factory=threading.Event)
    next_at: float | None = None
    next_s: float | None = None


class HoldService:
    """Begins, reads and ends holds."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: WorldDirectory,
        clocks: Mapping[str, Clock],
        waiting: WaitingGoals,
        wall_clock: WallClock = SYSTEM_CLOCK,
    ) -> None:
        """:param clocks: the worlds' clocks by the world's name."""
        self._database = core.database
        self._events = core.events
        self._facts = core.facts
        self._reservations = core.reservations
        self._knowledge_base = core.knowledge_base
        self._worlds = worlds
        self._clocks = clocks
        self._waiting = waiting
        self._wall_clock = wall_clock
        self._watched: dict[str, _Watched] = {}
        self._none_stand = KnownEmpty(core.database, HoldRow)
        core.database.committed.append(self._note_change)

    def issues(
        self, session: Session, world: WorldFile, holds: Sequence[StatedHold]
    ) -> tuple[GoalIssue, ...]:
        """The issues with holds in the record: running missions that stand against them, unknown ends."""
        return (
            *self._unknown_ends(session, world.name, [hold.until for hold in holds]),
            *self._needed(session, world, holds),
        )

    def _unknown_ends(self, session: Session, world: str, ends: Sequence[HoldEnd]) -> Iterable[GoalIssue]:
        for end in ends:
            if end.mission is not None:
                query = select(MissionRow.id).where(MissionRow.world == world, MissionRow.state.in_(OPEN))
                if end.mission not in (known := tuple(session.scalars(query))):
                    yield unknown_name("mission", end.mission, known)
            if end.goal is not None:
                goals = open_goals(session, world)
                if end.goal not in goals:
                    yield unknown_name("goal", end.goal, goals)

    def _needed(self, session: Session, world: WorldFile, holds: Sequence[StatedHold]) -> Iterable[GoalIssue]:
        stated = kept_by(holds)
        kept = places_in(stated.keep_empty, world)
        facts = [fact for fact in stated.keep if not any(unknown_in([fact], world))]
        for mission in self._reservations.of_world(session, world.name) if kept or facts else ():
            left = left_to_keep(facts, _goals_of(session, mission.mission_id) if facts else (), world)
            things = kept_things(left, world)
            for place in sorted((kept | things.places) & mission.filled, key=natural_key):
                yield _needs(mission.mission_id, f"puts a sample in {place}", place)
            moved = (things.samples & mission.reservation.samples) | (
                things.robots & mission.reservation.robots
            )
            for thing in sorted(moved, key=natural_key):
                yield _needs(mission.mission_id, f"uses {thing}", thing)

    def begin(
        self, session: Session, goal: GoalRow, holds: Sequence[StatedHold], world: WorldFile, *, actor: str
    ) -> tuple[GoalHold, ...]:
        """Record the holds that a goal states; they stand once the caller's transaction commits.

        The caller has locked the world, and has checked them since.

        :raises Busy: if too many stand already.
        """
        if not holds:
            return ()
        standing = len(standing_rows(session, world.name))
        if standing + len(holds) > MAX_STANDING:
            raise Busy(
                f"{standing} holds stand in {world.name}, the limit is {MAX_STANDING}; end some",
                code="too-many-holds",
            )
        return tuple(self._begin(session, goal, hold, world, actor=actor) for hold in holds)

    def _begin(
        self, session: Session, goal: GoalRow, hold: StatedHold, world: WorldFile, *, actor: str
    ) -> GoalHold:
        until = hold.until
        ends_at_s = None if until.in_s is None else self._clocks[world.name].now_s() + until.in_s
        facts = self._facts.facts(session, world.name)
        row = HoldRow(
            id=new_id("hold"),
            world=world.name,
            places=list(hold.places),
            kept=sorted(places_in(hold.places, world), key=natural_key),
            facts=[fact.model_dump(mode="json") for fact in hold.facts],
            achieved=[
                fact.model_dump(mode="json") for fact in hold.facts if is_kept_true(fact, world, facts)
            ],
            until=until.model_dump(mode="json", exclude_none=True),
            ends_at=None if until.at is None else until.at.timestamp(),
            ends_at_s=ends_at_s,
            state=HoldState.HELD,
            goal_id=goal.id,
            text=goal.text,
            created_by=actor,
        )
        session.add(row)
        self._events.append(
            session,
            HoldBegan(
                subject=row.id,
                world=world.name,
                places=hold.places,
                facts=tuple(map(str, hold.facts)),
                until=end_in_words(row),
                goal=goal.id,
                actor=actor,
            ),
        )
        return GoalHold(id=row.id, places=hold.places, facts=hold.facts, until=until)

    def of_world(self, world: str, *, state: HoldState, limit: int) -> Sequence[HoldRow]:
        """The holds of a world in this state, newest first."""
        self._worlds.refuse_unknown(world)
        query = select(HoldRow).where(HoldRow.world == world, HoldRow.state == state)
        newest = query.order_by(HoldRow.created_at.desc(), HoldRow.id.desc()).limit(limit)
        with self._database.read() as session:
            return session.scalars(newest).all()

    def end(self, world: str, hold_id: str, *, actor: str, comment: str) -> HoldRow:
        """End a hold early; ending it again changes nothing.

        :raises NotFound: if the world has no such hold.
        """
        self._worlds.refuse_unknown(world)
        with self._database.write() as session:
            self._facts.lock(session, world)
            row = session.get(HoldRow, hold_id, with_for_update=True)
            if row is None or row.world != world:
                choices = [one.id for one in standing_rows(session, world)]
                raise NotFound(f"{world} has no hold {hold_id!r}", code="unknown-hold", choices=choices)
            if row.state == HoldState.HELD:
                self._end(session, row, HoldEnding.OPERATOR, actor=actor, comment=comment)
            return row

    def follow(self, world: str) -> None:
        """End the holds whose end has come. Called often; reads only after a change, or at a hold's time."""
        watched = self._watched.get(world)
        if watched is None:
            watched = self._watched[world] = _Watched()
            watched.has_changed.set()
        if not watched.has_changed.is_set() and not self._is_time(world, watched):
            return
        watched.has_changed.clear()
        try:
            rows = self._none_stand.read(world, lambda: self._standing(world))
            if over := self._over(rows):
                self._end_over(world, over)
        except BaseException:  # the database is away; the next call tries again
            watched.has_changed.set()
            raise
        watched.next_at = min((r.ends_at for r in rows if r.ends_at is not None), default=None)
        watched.next_s = min((r.ends_at_s for r in rows if r.ends_at_s is not None), default=None)

    def _standing(self, world: str) -> Sequence[HoldRow]:
        with self._database.read() as session:
            return standing_rows(session, world)

    def _over(self, rows: Sequence[HoldRow]) -> Sequence[str]:
        """The ids of those whose end has come."""
        if not rows:
            return ()
        with self._database.read() as session:
            return [row.id for row in rows if self._ending(session, row) is not None]

    def _end_over(self, world: str, ids: Sequence[str]) -> None:
        with self._database.write() as session:
            self._facts.lock(session, world)
            for hold_id in ids:
                row = session.get_one(HoldRow, hold_id, with_for_update=True)
                ending = self._ending(session, row) if row.state == HoldState.HELD else None
                if ending is not None:
                    self._end(session, row, ending)

    def _is_time(self, world: str, watched: _Watched) -> bool:
        return (watched.next_at is not None and watched.next_at <= self._wall_clock.epoch_s()) or (
            watched.next_s is not None and watched.next_s <= self._clocks[world].now_s()
        )

    def _ending(self, session: Session, row: HoldRow) -> HoldEnding | None:
        """Why the hold ends now; None if it still stands."""
        until = HoldEnd.model_validate(row.until)
        ending: HoldEnding | None = None
        is_over = False
        if row.ends_at is not None:
            ending = HoldEnding.TIME
            is_over = row.ends_at <= self._wall_clock.epoch_s()
        elif row.ends_at_s is not None:
            ending = HoldEnding.TIME
            is_over = row.ends_at_s <= self._clocks[row.world].now_s()
        elif until.mission is not None:
            ending = HoldEnding.MISSION
            mission = session.get(MissionRow, until.mission)
            is_over = mission is None or mission.state not in OPEN
        elif until.goal is not None:
            ending = HoldEnding.GOAL
            goal = session.get(GoalRow, until.goal)
            is_over = goal is None or goal.state not in goal_lifecycle.OPEN
        elif until.fact is not None:
            ending = HoldEnding.FACT
            is_over = self._is_true(session, row.world, until.fact)
        return ending if is_over else None

    def _is_true(self, session: Session, world: str, fact: SymbolicFact) -> bool:
        """True if the fact is believed; not if the world no longer has what it names."""
        facts = self._facts.facts(session, world)
        try:
            return comes_true(fact, self._worlds[world], facts, self._knowledge_base)
        except KnowledgeBaseError:
            return False

    def _end(
        self,
        session: Session,
        row: HoldRow,
        ending: HoldEnding,
        *,
        actor: str | None = None,
        comment: str = "",
    ) -> None:
        end_hold(session, self._events, row, ending, self._wall_clock.epoch_s(), actor=actor, comment=comment)
        session.flush()
        self._waiting.release(session, row.world)

    def forget(self, world: str) -> None:
        """The world no longer runs."""
        self._watched.pop(world, None)

    def _note_change(self) -> None:
        for watched in tuple(self._watched.values()):
            watched.has_changed.set()


def _goals_of(session: Session, mission_id: str) -> Sequence[SymbolicFact]:
    goal = session.get_one(GoalRow, session.get_one(MissionRow, mission_id).goal_id)
    return [SymbolicFact.model_validate(fact) for fact in goal.goal]


def _needs(mission: str, does: str, thing: str) -> GoalIssue:
    return GoalIssue(
        code="needed-by-mission",
        kind="conflict",
        detail=f"mission {mission} {does}; cancel it, or wait for its end",
        thing=thing,
    )


def open_goals(session: Session, world: str) -> tuple[str, ...]:
    """The goals of a world that are not over, oldest first."""
    query = select(GoalRow.id).where(GoalRow.world == world, GoalRow.state.in_(goal_lifecycle.OPEN))
    return tuple(session.scalars(query.order_by(GoalRow.created_at, GoalRow.id)))


def open_aims(session: Session, world: str) -> tuple[SymbolicFact, ...]:
    """What the goals of a world that are not over are to make true, each fact once."""
    query = select(GoalRow.goal).where(GoalRow.world == world, GoalRow.state.in_(goal_lifecycle.OPEN))
    facts = (SymbolicFact.model_validate(fact) for goal in session.scalars(query) for fact in goal)
    return tuple(dict.fromkeys(facts))


def end_hold(
    session: Session,
    events: EventLog,
    row: HoldRow,
    ending: HoldEnding,
    epoch_s: float,
    *,
    actor: str | None = None,
    comment: str = "",
) -> None:
    """Record the end of a hold, with its event.

    :param epoch_s: when it ended, seconds since 1970.
    """
    hold_lifecycle.end(row, ending, at=iso_utc(epoch_s), actor=actor, comment=comment)
    ended = HoldEnded(
        subject=row.id,
        world=row.world,
        places=tuple(row.places),
        facts=tuple(map(str, facts_of(row))),
        why=ending,
        actor=actor,
        comment=comment,
    )
    events.append(session, ended)


def end_spans(session: Session, events: EventLog, world: str, epoch_s: float) -> None:
    """End the holds whose span counts on the clock of the world's earlier run."""
    for row in standing_rows(session, world):
        if row.ends_at_s is not None:
            end_hold(session, events, row, HoldEnding.NEW_RUN, epoch_s)
