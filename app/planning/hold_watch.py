"""Watches the facts that holds keep: tells when one is no longer true, and submits a goal that restores it."""

import threading
from collections.abc import Collection, Sequence
from contextlib import suppress

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.errors import Busy, Conflict, Invalid, NotFound
from app.domain.events import HoldFactLost, HoldFactRestored, HoldRestoring
from app.domain.goal_language.kept_facts import HoldFact, achieves
from app.domain.kept_record import KeptRecord, LostFact
from app.domain.lifecycles.goal import UNDECIDED, GoalState
from app.domain.lifecycles.hold import HoldState
from app.planning.goal_service import GoalRequest, GoalService
from app.store import GoalRow, HoldRow
from app.store.editions import WorldDirectory
from app.store.known_empty import KnownEmpty
from app.store.standing_holds import facts_of, standing_rows
from robots.wire import SymbolicFact


class HoldWatch:
    """Keeps the record of the facts that holds keep up to date with what is believed."""

    def __init__(self, core: Core, *, worlds: WorldDirectory, goals: GoalService) -> None:
        self._database = core.database
        self._events = core.events
        self._facts = core.facts
        self._worlds = worlds
        self._goals = goals
        self._changed: dict[str, threading.Event] = {}
        self._none_stand = KnownEmpty(core.database, HoldRow)
        core.database.committed.append(self._note_change)

    def follow(self, world: str) -> None:
        """Note what has ceased to be true, or is true again. Called often; reads only after a change."""
        changed = self._changed.get(world)
        if changed is None:
            changed = self._changed[world] = threading.Event()
            changed.set()
        if not changed.is_set():
            return
        changed.clear()
        try:
            ids = self._none_stand.read(world, lambda: self._keeping_facts(world))
            if ids and self._has_news(ids):
                self._note(world, ids)
            for hold_id, lost in self._unanswered(ids):
                self._restore(world, hold_id, lost)
            for goal in self._unneeded(world, ids):
                self._withdraw(goal)
        except BaseException:  # the database is away; the next call tries again
            changed.set()
            raise

    def forget(self, world: str) -> None:
        """The world no longer runs."""
        self._changed.pop(world, None)

    def _keeping_facts(self, world: str) -> Sequence[str]:
        """The holds of the world that stand and keep facts."""
        with self._database.read() as session:
            return [row.id for row in standing_rows(session, world) if row.facts]

    def _has_news(self, ids: Sequence[str]) -> bool:
        with self._database.read() as session:
            rows = _rows(session, ids)
            return any(self._observed(session, row) != record_of(row) for row in rows)

    def _observed(self, session: Session, row: HoldRow) -> KeptRecord:
        """The record of a hold with what is believed now; of one that is over, as it is."""
        record = record_of(row)
        if row.state != HoldState.HELD or row.world not in self._worlds:
            return record
        facts = self._facts.facts(session, row.world)
        in_work = self._in_work(session, row, record)
        return record.observe(facts_of(row), self._worlds[row.world], facts, in_work=in_work)

    def _in_work(self, session: Session, row: HoldRow, record: KeptRecord) -> Collection[HoldFact]:
        """The facts that running missions bring about, of the goal that states the hold or those that restore them."""
        found = {one.fact for one in record.lost if one.goal and _is_begun(session.get(GoalRow, one.goal))}
        stating = session.get(GoalRow, row.goal_id)
        if stating is not None and _is_begun(stating):
            world = self._worlds[row.world]
            goals = [SymbolicFact.model_validate(goal) for goal in stating.goal]
            found |= {fact for fact in facts_of(row) if any(achieves(goal, fact, world) for goal in goals)}
        return found

    def _note(self, world: str, ids: Sequence[str]) -> None:
        """Bring the records up to date, and tell what has changed."""
        with self._database.write() as session:
            self._facts.lock(session, world)
            for hold_id in ids:
                row = session.get(HoldRow, hold_id, with_for_update=True)
                if row is not None:
                    before = record_of(row)
                    after = self._observed(session, row)
                    _set_record(row, after)
                    self._tell(session, row, before, after)

    def _tell(self, session: Session, row: HoldRow, before: KeptRecord, after: KeptRecord) -> None:
        known = {one.fact for one in before.lost}
        lost = {one.fact: one for one in after.lost}
        for fact, one in lost.items():
            if fact not in known:
                told = HoldFactLost(subject=row.id, world=row.world, fact=str(fact), now=one.now)
                self._events.append(session, told)
        for fact in known - lost.keys():
            self._events.append(session, HoldFactRestored(subject=row.id, world=row.world, fact=str(fact)))

    def _unanswered(self, ids: Sequence[str]) -> Sequence[tuple[str, LostFact]]:
        """The losses for which no goal was submitted, with their holds."""
        if not ids:
            return ()
        with self._database.read() as session:
            rows = _rows(session, ids)
            return [
                (row.id, lost)
                for row in rows
                for lost in record_of(row).lost
                if row.state == HoldState.HELD and lost.is_unanswered
            ]

    def _unneeded(self, world: str, ids: Sequence[str]) -> Sequence[GoalRow]:
        """The goals submitted for these holds that are not carried out yet, and whose facts are true again.

        Found by what is recorded: a withdrawal that a failure cut off is made up for by the next call.
        """
        if not ids:
            return ()
        with self._database.read() as session:
            rows = _rows(session, ids)
            needed = {lost.goal for row in rows for lost in record_of(row).lost}
            submitted = select(GoalRow).where(
                GoalRow.world == world, GoalRow.state.in_(UNDECIDED), GoalRow.created_by.in_(ids)
            )
            return [goal for goal in session.scalars(submitted) if goal.id not in needed]

    def _withdraw(self, goal: GoalRow) -> None:
        """Cancel a goal that was to restore what is true again by itself, unless it has begun or is over since."""
        with suppress(Conflict, NotFound):
            self._goals.cancel(goal.id, actor=goal.created_by, comment=f"{goal.text} is true again")

    def _restore(self, world: str, hold_id: str, lost: LostFact) -> None:
        """Submit a goal that brings the fact about again, as the goal that states the hold is approved.

        The key makes it the same goal if a process ended before it was noted.
        """
        with self._database.read() as session:
            row = session.get_one(HoldRow, hold_id)
            stating = session.get(GoalRow, row.goal_id)
        request = GoalRequest(
            world=world,
            goal=[SymbolicFact(predicate=lost.fact.predicate, args=lost.fact.args)],
            priority=0 if stating is None else stating.priority,
            auto_approve=stating is not None and stating.auto_approve,
        )
        try:
            goal = self._goals.submit(request, actor=hold_id, key=f"{hold_id} {lost.number}")
        except Busy:  # too many goals are open; the next change tries again
            return
        except (Conflict, Invalid) as refusal:
            self._answer(hold_id, lost.number, goal=None, reason=str(refusal))
            return
        self._answer(hold_id, lost.number, goal=goal.id, reason="")

    def _answer(self, hold_id: str, number: int, *, goal: str | None, reason: str) -> None:
        with self._database.write() as session:
            row = session.get_one(HoldRow, hold_id, with_for_update=True)
            _set_record(row, record_of(row).answered(number, goal=goal, reason=reason))
            told = HoldRestoring(subject=row.id, world=row.world, goal=goal, reason=reason)
            self._events.append(session, told)

    def _note_change(self) -> None:
        for changed in tuple(self._changed.values()):
            changed.set()


def _rows(session: Session, ids: Sequence[str]) -> Sequence[HoldRow]:
    return [row for hold_id in ids if (row := session.get(HoldRow, hold_id)) is not None]


def record_of(row: HoldRow) -> KeptRecord:
    """What is known of the facts that a hold keeps."""
    return KeptRecord(
        achieved=tuple(HoldFact.model_validate(fact) for fact in row.achieved),
        lost=tuple(LostFact.model_validate(lost) for lost in row.lost),
        losses=row.losses,
    )


def _set_record(row: HoldRow, record: KeptRecord) -> None:
    row.achieved = [fact.model_dump(mode="json") for fact in record.achieved]
    row.lost = [lost.model_dump(mode="json") for lost in record.lost]
    row.losses = record.losses


def _is_begun(goal: GoalRow | None) -> bool:
    return goal is not None and goal.state == GoalState.COMMITTED
