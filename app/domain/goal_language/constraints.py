"""Constraints on how a goal is carried out: which robots, which places; checked against the world, applied to facts."""

from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from math import inf
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from app.domain.goal_language.berth_choice import remaining_samples
from app.domain.goal_language.issues import GoalIssue, unknown_name
from app.domain.goal_language.roles import robots_for, unknown_robot
from app.domain.goal_language.words import joined, natural_key
from app.domain.world_model.beliefs import IN, VACANT, Facts, place_of, position_of
from app.domain.world_model.berths import berths_of
from app.domain.world_model.reservation import Reservation, filled_by, is_withheld, taken_by
from planner import Fact, Numbers, PlanNet, number_words
from robots.wire import SymbolicFact
from robots.world import WorldFile, ZoneRule

Name = Annotated[str, Field(min_length=1, max_length=64)]
Names = tuple[Name, ...]
MAX_NAMES = 1000
"""The most names, and the most stages, of a goal's constraints."""
MAX_WORTH = 1e6


class Constraints(BaseModel):
    """How a goal is to be carried out; empty fields constrain nothing."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    robots: Names = Field(
        default=(), description="only these robots act; a role stands for those that play it"
    )
    without: Names = Field(default=(), description="these robots do not act; roles likewise")
    avoid: Names = Field(
        default=(),
        description="places that no robot goes to, and where nothing is put or taken",
    )
    keep_empty: Names = Field(default=(), description="places where no sample is put")
    after: Names = Field(
        default=(), description="missions, by id, that have ended before the goal is planned"
    )
    at_least: dict[Name, Annotated[float, Field(allow_inf_nan=False)]] = Field(
        default_factory=dict,
        max_length=20,
        description="only robots act of which these numeric facts are at least so much when the plan is made",
        examples=[{"battery": 0.4}],
    )
    stages: tuple[Annotated[int, Field(ge=0, le=MAX_NAMES)], ...] = Field(
        default=(),
        description="for each goal its stage; a stage is begun once the goals of the earlier ones are achieved; empty: "
        "all goals are pursued together",
    )
    worth: tuple[Annotated[float, Field(gt=0, le=MAX_WORTH, allow_inf_nan=False)] | None, ...] = Field(
        default=(),
        description="for each goal what it is worth if it may be left out, null if it must be achieved; the deadline "
        "is then kept by leaving out; empty: all must be achieved",
        examples=[[None, 5, 2.5]],
    )

    def __bool__(self) -> bool:
        return bool(
            self.robots
            or self.without
            or self.avoid
            or self.keep_empty
            or self.after
            or self.at_least
            or any(self.stages)
            or self.has_optional_goals
        )

    @property
    def has_optional_goals(self) -> bool:
        return any(worth is not None for worth in self.worth)

    def and_also(self, other: "Constraints") -> "Constraints":
        """Both constraints. Robots are those that both allow; if there are none, all of the others are left out."""
        robots = tuple(dict.fromkeys((*self.robots, *other.robots)))
        barred: Names = ()
        if self.robots and other.robots:
            shared = {*self.robots} & {*other.robots}
            barred = tuple(robot for robot in robots if robot not in shared)
        return Constraints(
            robots=robots,
            without=_union(self.without, other.without, barred),
            avoid=_union(self.avoid, other.avoid),
            keep_empty=_union(self.keep_empty, other.keep_empty),
            after=_union(self.after, other.after),
            at_least={
                name: max(given[name] for given in (self.at_least, other.at_least) if name in given)
                for name in (*self.at_least, *other.at_least)
            },
            stages=self.stages or other.stages,
            worth=self.worth or other.worth,
        )

    @property
    def words(self) -> tuple[str, ...]:
        """Each constraint in words."""
        parts = (
            ("only with", self.robots),
            ("without", self.without),
            ("avoiding", self.avoid),
            ("keeping empty:", self.keep_empty),
            ("after", self.after),
        )
        least = tuple(f"{name} >= {number_words(number)}" for name, number in self.at_least.items())
        return (
            *(f"{said} {joined(names, last='and')}" for said, names in parts if names),
            *((f"only with robots of {joined(least, last='and')}",) if least else ()),
        )

    def of_robots(self, world: WorldFile) -> "Constraints":
        """The same with the robots that play it now in place of each role."""
        named = {"robots": robots_for(self.robots, world), "without": robots_for(self.without, world)}
        return self.model_copy(update=named)

    def in_world(self, world: WorldFile, numbers: Numbers | None = None) -> "AppliedConstraints":
        """The constraints on the robots and places of this world, and those of its zones to keep out of."""
        areas = tuple(zone.name for zone in world.zones_of(ZoneRule.KEEP_OUT))
        of_robots = self.of_robots(world)
        return AppliedConstraints(
            excluded=frozenset(
                robot.name for robot in world.robots if not of_robots._allows(robot.name, numbers)
            ),
            avoided=_places(self.avoid, world).union(world.kept_out),
            kept_empty=_places(self.keep_empty, world),
            words=(*self.words, *((f"keeping out of {joined(areas, last='and')}",) if areas else ())),
        )

    def stages_of(self, goals: Sequence[Fact]) -> dict[Fact, int]:
        """The stage of each goal; empty if all are pursued together."""
        stages = dict(zip(goals, self.stages, strict=True)) if self.stages else {}
        return stages if len(set(stages.values())) > 1 else {}

    def values_of(self, goals: Sequence[Fact]) -> dict[Fact, float]:
        """The goals that may be left out, and what each is worth."""
        worth = zip(goals, self.worth, strict=True) if self.worth else ()
        return {goal: value for goal, value in worth if value is not None}

    def _allows(self, robot: str, numbers: Numbers | None) -> bool:
        enough = numbers is None or all(
            numbers.get((quantity, (robot,)), -inf) >= number for quantity, number in self.at_least.items()
        )
        return enough and robot not in self.without and (not self.robots or robot in self.robots)


UNCONSTRAINED = Constraints()


class AppliedConstraints(BaseModel):
    """Constraints by the names of a world: robots that do not act, places (berths, not locations) not to be used.

    :param words: each constraint in words.
    """

    model_config = ConfigDict(frozen=True, ignored_types=(cached_property,))

    excluded: frozenset[str] = frozenset()
    avoided: frozenset[str] = frozenset()
    kept_empty: frozenset[str] = frozenset()
    words: tuple[str, ...] = ()

    def explaining(self, reason: str) -> str:
        """A reason why there is no plan, with the constraints under which it holds."""
        words = joined(self.words, last="and") if self.words else ""
        return reason if not words or reason.endswith(words) else f"{reason}, {words}"

    @cached_property
    def withheld(self) -> Reservation:
        """What no plan may use."""
        return Reservation(robots=self.excluded, locations=self.avoided)

    def keeping_empty(self, places: frozenset[str]) -> "AppliedConstraints":
        """The same, with these places kept empty, too."""
        return self.model_copy(update={"kept_empty": self.kept_empty | places})

    def applied_to(self, facts: Facts) -> Facts:
        """The facts that a plan may rest on.

        NOTE: a place that is to be kept empty has no room; robots may still pass it, and samples may leave it.
        """
        if not (self.excluded or self.avoided or self.kept_empty):
            return facts
        return frozenset(
            fact
            for fact in facts
            if not is_withheld(fact, self.withheld)
            and not (fact.predicate == VACANT and fact.args[0] in self.kept_empty)
        )

    def broken_by(self, net: PlanNet) -> tuple[str, ...]:
        """How a plan-net breaks the constraints, in words; empty if it keeps them."""
        taken = taken_by(net)
        wrong = (
            ("uses", self.excluded & taken.robots),
            ("goes to", self.avoided & taken.locations),
            ("puts a sample in", self.kept_empty & filled_by(net.actions)),
        )
        return tuple(
            f"it {what} {joined(sorted(names, key=natural_key), last='and')}"
            for what, names in wrong
            if names
        )


NOTHING_WITHHELD = AppliedConstraints()


def check_constraints(
    constraints: Constraints, goals: Sequence[SymbolicFact], world: WorldFile, facts: Facts
) -> tuple[GoalIssue, ...]:
    """The issues with constraints on these goals: unknown names, and contradictions to a goal or a fact."""
    lists = (
        constraints.robots,
        constraints.without,
        constraints.avoid,
        constraints.keep_empty,
        constraints.after,
    )
    count = sum(map(len, lists))
    if count > MAX_NAMES:
        detail = f"{count} names are more than the {MAX_NAMES} that constraints may have"
        return (GoalIssue(code="too-many-names", kind="invalid", detail=detail),)
    unknown = tuple(_unknown_names(constraints, world))
    return unknown or tuple(dict.fromkeys(_contradictions(constraints, goals, world, facts)))


def _unknown_names(constraints: Constraints, world: WorldFile) -> Iterator[GoalIssue]:
    robots = [robot.name for robot in world.robots]
    places = list(dict.fromkeys((*world.places_by_location, *world.location_of)))
    for name in robots_for((*constraints.robots, *constraints.without), world):
        if name not in robots:
            yield unknown_robot(name, world)
    yield from _unknown("place", (*constraints.avoid, *constraints.keep_empty), places)


def _unknown(what: str, names: Iterable[str], known: Sequence[str]) -> Iterator[GoalIssue]:
    for name in dict.fromkeys(names):
        if name not in known:
            yield unknown_name(what, name, known)


def _contradictions(
    constraints: Constraints, goals: Sequence[SymbolicFact], world: WorldFile, facts: Facts
) -> Iterator[GoalIssue]:
    applied = constraints.in_world(world)
    if constraints.stages and len(constraints.stages) != len(goals):
        yield GoalIssue(
            code="stages-of-other-goals",
            kind="invalid",
            detail=f"stages has {len(constraints.stages)} entries for {len(goals)} goals; give one for each goal",
        )
    if constraints.worth and len(constraints.worth) != len(goals):
        yield GoalIssue(
            code="worth-of-other-goals",
            kind="invalid",
            detail=f"worth has {len(constraints.worth)} entries for {len(goals)} goals; give one for each goal, null "
            "for those that must be achieved",
        )
    if not {robot.name for robot in world.robots} - applied.excluded:
        yield GoalIssue(
            code="no-robot-left",
            kind="invalid",
            detail=f"no robot is left to act: {joined(constraints.words, last='and')}",
            choices=tuple(sorted(robot.name for robot in world.robots)),
        )
    for goal in goals:
        if len(goal.args) != 2:
            continue
        subject, place = goal.args
        if subject in applied.excluded and not _stands(subject, goal, facts):
            yield _contradicted(f"{goal} needs {subject}, which is not to act", subject)
        named = {place, *berths_of(place, world)} if place in world.places_by_location else {place}
        targets = named - {place} or named
        if targets <= applied.avoided:
            yield _contradicted(f"{goal} is at {place}, which {_why_avoided(targets, world)}", place)
        if goal.predicate == IN and targets <= applied.kept_empty:
            yield _contradicted(f"{goal} fills {place}, which is to be kept empty", place)
        lies = place_of(subject, facts) if goal.predicate == IN else None
        if lies is not None and lies in applied.avoided and lies not in named:
            yield _contradicted(f"{subject} lies in {lies}, which {_why_avoided({lies}, world)}", lies)
    for place in sorted(applied.kept_empty, key=natural_key):
        if there := remaining_samples(place, goals, world, facts):
            yield GoalIssue(
                code="place-occupied",
                kind="conflict",
                detail=f"{place} is to be kept empty, but {joined(there, last='and')} lies there",
                thing=place,
            )


def _why_avoided(places: Iterable[str], world: WorldFile) -> str:
    areas = sorted({world.kept_out[place] for place in places if place in world.kept_out})
    return f"is in {areas[0]}, a zone to keep out of" if areas else "is to be avoided"


def _stands(robot: str, goal: SymbolicFact, facts: Facts) -> bool:
    position = position_of(robot, facts)
    return position is not None and position.args == (robot, goal.predicate, goal.args[1])


def _contradicted(detail: str, thing: str) -> GoalIssue:
    return GoalIssue(code="constraint-contradicts-goal", kind="invalid", detail=detail, thing=thing)


def _places(names: Iterable[str], world: WorldFile) -> frozenset[str]:
    """The places of these locations: their berths, where they have several."""
    return frozenset(place for name in names for place in berths_of(name, world) or (name,))


def _union(*groups: Names) -> Names:
    return tuple(dict.fromkeys(name for group in groups for name in group))
