"""The worlds and their facts as clients see them, and operators' corrections of facts."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session, undefer

from app.agents.running_world import WorldState, WorldStatus
from app.core import Core
from app.domain.durations import Durations
from app.domain.errors import Invalid, Outdated, UnknownWorld
from app.domain.events import FactsCorrected, NumbersCorrected
from app.domain.lifecycles.recovery import answer_troubles
from app.domain.world_model.beliefs import (
    DERIVED,
    OBJECT_POSITION,
    REACHES,
    ROBOT_POSITION,
    Facts,
    belief_change,
    contradiction,
    spot_of,
)
from app.domain.world_model.berths import Statement, resolve_statements
from app.domain.world_model.numbers import Things, check_term, check_value, words_of
from app.domain.world_model.problem import objects_of
from app.domain.world_model.vocabulary import stated_fact, symbolic, symbolic_all
from app.store import FactRow, NumberRow, WorldRow
from app.store.durations import learned_durations
from app.store.editions import WorldDirectory
from app.store.records import lock_running_missions
from app.store.unknowns import Unknown, list_unknowns
from app.workflows.mission_wakeups import wake_missions
from planner import Fact, KnowledgeBaseError, number_words
from planner.knowledge.comparison import Term
from robots.clock import Clock
from robots.wire import SymbolicFact
from robots.world import WorldFile

Relation = tuple[str, tuple[str, ...]]
StatedNumber = tuple[str, Sequence[str], float]
"""Quantity, arguments and value."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldReport:
    id: str
    name: str
    title: str
    time_s: float
    version: int
    edition: int
    numbers_version: int
    layout: Mapping[str, Any]
    status: WorldState
    status_detail: str


class WorldService:
    """Reads worlds and facts; takes operators' corrections."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: WorldDirectory,
        clocks: Mapping[str, Clock],
        status: Callable[[str], WorldStatus],
        find: Callable[[str], None] = lambda world: None,
    ) -> None:
        """
        :param clocks: by world.
        :param status: whether messages are exchanged with a world.
        :param find: looks again for a world of that name, which another process may just have added.
        """
        self._status = status
        self._find = find
        self._database = core.database
        self._events = core.events
        self._facts = core.facts
        self._numbers = core.facts.numbers
        self.knowledge_base = core.knowledge_base
        self._workflows = core.workflows
        self._worlds = worlds
        self._clocks = clocks
        self.numbers_corrected: list[Callable[[Session, str], None]] = []
        """Called with the transaction and the world once an operator has corrected numbers."""

    def reports(self) -> list[WorldReport]:
        """Every world, those given at the start first; the page shows the first one by default."""
        names = tuple(self._worlds)
        with self._database.read() as session:
            query = select(WorldRow).where(WorldRow.id.in_(names)).options(undefer(WorldRow.layout))
            rows = {row.id: row for row in session.scalars(query)}
        reports = []
        for name in names:
            with suppress(UnknownWorld):  # it was removed just now
                reports += [self._report(rows[name])] if name in rows else []
        return reports

    def get(self, world: str) -> WorldReport:
        self.world(world)
        with self._database.read() as session:
            return self._report(session.get_one(WorldRow, world, options=[undefer(WorldRow.layout)]))

    def world(self, name: str | None) -> WorldFile:
        """The world of that name; with None, the only one there is.

        :raises NotFound: if there is no such world; `choices` are those that run.
        :raises Invalid: if no name is given and several run.
        """
        if name is None and len(self._worlds) == 1:
            return next(iter(self._worlds.values()))
        if name is None:
            raise Invalid("several worlds run: name one", code="world-needed", choices=sorted(self._worlds))
        self._find(name)
        return self._worlds[name]

    def facts(self, world: str) -> tuple[Sequence[tuple[Relation, FactRow]], int]:
        """Every fact in rel/ref form with its row, and the version they are of."""
        self.world(world)
        with self._database.read() as session:
            # First: a fact that is added meanwhile belongs to a later version.
            version = self._facts.version(session, world)
            rows = self._facts.rows(session, world)
        form = self.knowledge_base.to_relation
        return [(form(Fact(row.predicate, tuple(row.args))), row) for row in rows], version

    def version(self, world: str) -> int:
        """The version of the world's facts: it increases with every change of them."""
        self.world(world)
        with self._database.read() as session:
            return self._facts.version(session, world)

    def edition(self, world: str) -> int:
        """The edition of the world itself: it increases with every change of it."""
        return self._worlds.edition(world).number

    def unknown(self, world: str) -> Sequence[Unknown]:
        """Samples without a believed place, and robots that are lost or do not answer."""
        samples = [sample.name for sample in self.world(world).samples]
        with self._database.read() as session:
            return list_unknowns(
                session,
                world,
                known=self._facts.believed(session, world),
                samples=samples,
                under_way=self.knowledge_base.under_way,
            )

    def relation(self, fact: Fact) -> Relation:
        """The fact in rel/ref form."""
        return self.knowledge_base.to_relation(fact)

    def durations(self, world: str) -> Durations:
        """The learned durations of actions in the world."""
        self.world(world)
        with self._database.read() as session:
            return learned_durations(session, world)

    def correct(
        self,
        world: str,
        changes: Sequence[Statement],
        *,
        actor: str,
        comment: str,
        expected_version: int | None,
    ) -> tuple[SymbolicFact, ...]:
        """Make facts true or false as an operator states; returns the facts dropped because they contradict them.

        `vacant` and `clear` are derived from the other facts and do not count as dropped.

        :raises Invalid: if a fact does not fit the vocabulary, contradicts another of the changes, puts a robot
            where it does not reach or a sample where none may lie; then none is changed.
        :raises Conflict: if a sample is laid in a location none of whose berths is free.
        :raises Outdated: if the facts have changed since `expected_version`.
        """
        self.world(world)
        with self._database.write() as session:
            missions = lock_running_missions(session, world)  # lock order: missions before the world
            self._facts.lock(session, world)
            _refuse_outdated(world, self._facts.version(session, world), expected_version)
            facts = self._facts.facts(session, world)
            news, gone = self._parsed(world, changes, facts)
            self._refuse_contradictions(facts, news, gone)
            self._refuse_without_room(world, news)
            change = belief_change(facts, news=news, gone=gone)
            self._refuse_out_of_reach(world, change.apply(facts), news)
            self._facts.change(
                session,
                world,
                add=change.add,
                remove=change.remove,
                source=f"operator {actor}",
                at_s=self._clocks[world].now_s(),
                corrects=True,
            )
            corrected_names = {name for fact in (*news, *gone) for name in fact.args}
            for mission in missions:
                answer_troubles(mission, lambda trouble: trouble.is_answered_by(corrected_names))
            unsaid = (f for f in sorted(change.remove - set(gone)) if f.predicate not in DERIVED)
            dropped = symbolic_all(unsaid, self.knowledge_base)
            corrected = FactsCorrected(subject=world, actor=actor, comment=comment, dropped=dropped)
            self._events.append(session, corrected)
            wake_missions(session, self._workflows, world)
            return dropped

    def numbers(self, world: str) -> tuple[Sequence[NumberRow], int]:
        """Every numeric fact, and the version they are of."""
        self.world(world)
        with self._database.read() as session:
            # First: a number that changes meanwhile belongs to a later version.
            version = self._numbers.version(session, world)
            return self._numbers.rows(session, world), version

    def numbers_version(self, world: str) -> int:
        """The version of the world's numeric facts: it increases with every change of them."""
        self.world(world)
        with self._database.read() as session:
            return self._numbers.version(session, world)

    def correct_numbers(
        self,
        world: str,
        changes: Sequence[StatedNumber],
        *,
        actor: str,
        comment: str,
        expected_version: int | None,
    ) -> None:
        """Give numeric facts the values that an operator states, all or none.

        :raises Invalid: if one is not of the vocabulary, out of its range, counted from facts, or stated twice.
        :raises Outdated: if the numbers have changed since `expected_version`.
        """
        things = Things.of(self.world(world))
        numbers: dict[Term, float] = {}
        for quantity, args, value in changes:
            term = check_term(quantity, args, things, self.knowledge_base)
            check_value(quantity, value, self.knowledge_base)
            if numbers.setdefault(term, value) != value:
                raise Invalid(
                    f"{quantity}({', '.join(term[1])}) is stated to be {number_words(numbers[term])} and "
                    f"{number_words(value)}",
                    code="contradicting-numbers",
                    thing=quantity,
                )
        with self._database.write() as session:
            self._facts.lock(session, world)
            version = self._numbers.version(session, world)
            if expected_version not in (None, version):
                raise Outdated(
                    f"the numbers of {world} are at version {version}, the correction was made from "
                    f"{expected_version}",
                    code="numbers-changed",
                )
            source = f"operator {actor}"
            self._numbers.set(session, world, numbers, source=source, at_s=self._clocks[world].now_s())
            stated = tuple(words_of(term, value, self.knowledge_base) for term, value in numbers.items())
            corrected = NumbersCorrected(subject=world, actor=actor, comment=comment, stated=stated)
            self._events.append(session, corrected)
            for call in self.numbers_corrected:
                call(session, world)

    def _parsed(
        self, world: str, changes: Sequence[Statement], facts: Facts
    ) -> tuple[list[Fact], list[Fact]]:
        """The facts that became true and those that proved false, in the planner's form."""
        objects = objects_of(self.world(world))
        said = resolve_statements(changes, self.world(world), facts)
        try:
            parsed = [(stated_fact(p, a, self.knowledge_base, objects), value) for p, a, value in said]
        except KnowledgeBaseError as error:
            raise Invalid(str(error), code="malformed-fact") from error
        return [fact for fact, value in parsed if value], [fact for fact, value in parsed if not value]

    def _refuse_contradictions(self, facts: Facts, news: Sequence[Fact], gone: Sequence[Fact]) -> None:
        """Refuse changes that exclude each other: the later would silently win."""
        both = next((fact for fact in news if fact in gone), None)
        if both is not None:
            said = symbolic(both, self.knowledge_base)
            raise Invalid(f"{said} is stated both as true and as false", code="contradicting-facts")
        pair = contradiction(facts, news)
        if pair is not None:
            one, other = symbolic_all(pair, self.knowledge_base)
            raise Invalid(f"{one} and {other} cannot both be true", code="contradicting-facts")

    def _refuse_without_room(self, world: str, news: Sequence[Fact]) -> None:
        places = {place.name: place for place in self.world(world).places}
        for fact in news:
            if fact.predicate != OBJECT_POSITION or fact.args[2] not in places:
                continue
            place = places[fact.args[2]]
            if place.capacity == 0:
                raise Invalid(
                    f"{symbolic(fact, self.knowledge_base)}: {place.name} is a {place.kind}, it holds no samples",
                    code="place-holds-no-samples",
                    choices=[one.name for one in places.values() if one.capacity],
                )

    def _refuse_out_of_reach(self, world: str, after: Facts, news: Sequence[Fact]) -> None:
        for fact in news:
            if fact.predicate != ROBOT_POSITION:
                continue
            robot, _, place = fact.args
            reached = {f.args[1] for f in after if f.predicate == REACHES and f.args[0] == robot}
            if place not in reached | {spot_of(robot)}:
                raise Invalid(
                    f"{symbolic(fact, self.knowledge_base)}: {robot} does not reach {place}",
                    code="place-unreachable",
                    choices=[p.name for p in self.world(world).places if p.name in reached],
                )

    def _report(self, row: WorldRow) -> WorldReport:
        status = self._status(row.id)
        return WorldReport(
            id=row.id,
            name=row.id,
            title=row.title,
            time_s=self._clocks[row.id].now_s(),
            version=row.version,
            edition=self._worlds.edition(row.id).number,
            numbers_version=row.numbers_version,
            layout=row.layout,
            status=status.state,
            status_detail=status.detail,
        )


def _refuse_outdated(world: str, version: int, expected: int | None) -> None:
    if expected not in (None, version):
        detail = f"the facts of {world} are at version {version}, the correction was made from {expected}"
        raise Outdated(detail, code="facts-changed")
