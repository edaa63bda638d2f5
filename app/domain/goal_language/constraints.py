"""Constraints on how a goal is carried out: which robots, which places; checked against the world, applied to facts."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property, reduce
from math import inf
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from app.domain.goal_language.berth_choice import remaining_samples
from app.domain.goal_language.issues import GoalIssue, unknown_name
from app.domain.goal_language.kept_facts import (
    HoldFact,
    Name,
    believed_now,
    contradicts,
    is_kept_true,
    kept_things,
    left_to_keep,
    unknown_in,
)
from app.domain.goal_language.roles import robots_for, unknown_robot, with_players
from app.domain.goal_language.words import joined, natural_key
from app.domain.world_model.beliefs import IN, VACANT, Facts, place_of, position_of
from app.domain.world_model.berths import berths_of
from app.domain.world_model.reservation import Reservation, filled_by, is_withheld, taken_by
from planner import Fact, Numbers, PlanNet, number_words
from planner import Preference as PlannerPreference
from planner.problem.preference import MAX_PREFERENCES
from robots.wire import SymbolicFact
from robots.world import WorldFile, ZoneRule

Names = tuple[Name, ...]
MAX_NAMES = 1000
"""The most names, and the most stages, of a goal's constraints."""
MAX_WORTH = 1e6
DEFAULT_COST_S = 60.0
"""What breaking a preference costs unless told, in seconds of makespan (our choice)."""


class _OnRobotsAndPlaces(BaseModel):
    """What may be required of a plan, or preferred."""

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
    at_least: dict[Name, Annotated[float, Field(allow_inf_nan=False)]] = Field(
        default_factory=dict,
        max_length=20,
        description="only robots act of which these numeric facts are at least so much when the plan is made",
        examples=[{"battery": 0.4}],
    )


class StatedPreference(_OnRobotsAndPlaces):
    """A constraint that a plan may break at a cost: one of the fields beside `cost_s` says which."""

    cost_s: float = Field(
        default=DEFAULT_COST_S,
        gt=0,
        le=MAX_WORTH,
        allow_inf_nan=False,
        description="seconds of makespan that keeping it is worth",
    )

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        stated = [name for name in _OnRobotsAndPlaces.model_fields if getattr(self, name)]
        if len(stated) != 1:
            choices = joined(tuple(_OnRobotsAndPlaces.model_fields))
            raise ValueError(f"a preference states one constraint, {choices}; this one has {len(stated)}")
        return self

    @property
    def constraint(self) -> "Constraints":
        """What it would be if it were required."""
        return Constraints(**self.model_dump(exclude={"cost_s"}))

    @property
    def words(self) -> str:
        return f"preferably {self.constraint.words[0]}"


class Constraints(_OnRobotsAndPlaces):
    """How a goal is to be carried out; empty fields constrain nothing."""

    keep: tuple[HoldFact, ...] = Field(
        default=(),
        max_length=MAX_NAMES,
        description="facts in(sample, place) and near(robot, place) that are true and that no action ends: the "
        "sample is not moved, the robot does not act",
    )
    after: Names = Field(
        default=(), description="missions, by id, that have ended before the goal is planned"
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
    preferences: tuple[StatedPreference, ...] = Field(
        default=(),
        description=f"at most {MAX_PREFERENCES} constraints that a plan may break, each at a cost; the plan has the "
        "smallest sum of makespan and costs of broken preferences",
        examples=[[{"without": ["yard_1"], "cost_s": 20}]],
    )

    def __bool__(self) -> bool:
        return bool(
            self.robots
            or self.without
            or self.avoid
            or self.keep_empty
            or self.keep
            or self.after
            or self.at_least
            or any(self.stages)
            or self.has_optional_goals
            or self.preferences
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
            keep=tuple(dict.fromkeys((*self.keep, *other.keep))),
            after=_union(self.after, other.after),
            at_least={
                name: max(given[name] for given in (self.at_least, other.at_least) if name in given)
                for name in (*self.at_least, *other.at_least)
            },
            stages=self.stages or other.stages,
            worth=self.worth or other.worth,
            preferences=(
                *self.preferences,
                *(preference for preference in other.preferences if preference not in self.preferences),
            ),
        )

    @classmethod
    def all_of(cls, parts: Iterable["Constraints"]) -> "Constraints":
        """All of the constraints."""
        return reduce(Constraints.and_also, parts, cls())

    @property
    def parts(self) -> tuple["Constraints", ...]:
        """The constraints on robots and places one by one: each robot or place that is not to be used, the robots that
        alone may act, and each number that they have at least."""
        return (
            *((Constraints(robots=self.robots),) if self.robots else ()),
            *(Constraints(without=(name,)) for name in self.without),
            *(Constraints(avoid=(name,)) for name in self.avoid),
            *(Constraints(keep_empty=(name,)) for name in self.keep_empty),
            *(Constraints(keep=(fact,)) for fact in self.keep),
            *(Constraints(at_least={name: number}) for name, number in self.at_least.items()),
        )

    @property
    def beside_parts(self) -> "Constraints":
        """All but the constraints on robots and places."""
        return self.model_copy(
            update={
                "robots": (),
                "without": (),
                "avoid": (),
                "keep_empty": (),
                "keep": (),
                "at_least": {},
            }
        )

    def without_each(self) -> Mapping[str, "Constraints"]:
        """For each constraint on robots and places, in words, all the others."""
        parts = self.parts
        rest = {name: getattr(self, name) for name in ("after", "stages", "worth", "preferences")}
        return {
            part.words[0]: Constraints.all_of(other for other in parts if other is not part).model_copy(
                update=rest
            )
            for part in parts
        }

    @property
    def words(self) -> tuple[str, ...]:
        """Each constraint in words."""
        parts = (
            ("only with", self.robots),
            ("without", self.without),
            ("avoiding", self.avoid),
            ("keeping empty:", self.keep_empty),
            ("keeping", tuple(fact.words for fact in self.keep)),
            ("after", self.after),
        )
        least = tuple(f"{name} >= {number_words(number)}" for name, number in self.at_least.items())
        return (
            *(f"{said} {joined(names, last='and')}" for said, names in parts if names),
            *((f"only with robots of {joined(least, last='and')}",) if least else ()),
        )

    @property
    def preference_words(self) -> tuple[str, ...]:
        """Each preference in words, with what breaking it costs."""
        return tuple(f"{preference.words} (cost {preference.cost_s:g} s)" for preference in self.preferences)

    def of_robots(self, world: WorldFile) -> "Constraints":
        """The same with the robots that play it now in place of each role."""
        named = {"robots": robots_for(self.robots, world), "without": robots_for(self.without, world)}
        return self.model_copy(update=named)

    def of_goals(
        self, goals: Sequence[SymbolicFact], world: WorldFile
    ) -> tuple[tuple[SymbolicFact, ...], "Constraints"]:
        """The goals with one for each player in place of each that names a role, and the same with their stages and
        worth."""
        _, worth = with_players(goals, self.worth, world)
        of_players, stages = with_players(goals, self.stages, world)
        return of_players, self.model_copy(update={"stages": stages, "worth": worth})

    def without_achieved(self, goals: Sequence[SymbolicFact], world: WorldFile) -> "Constraints":
        """The same without the facts to keep that the goals bring about: a plan for them may move what they name."""
        if not self.keep:
            return self
        return self.model_copy(update={"keep": left_to_keep(self.keep, goals, world)})

    def kept_off(self, world: WorldFile) -> frozenset[str]:
        """The places where nothing is to be put, by what is required and what is preferred."""
        every = (self, *(preference.constraint for preference in self.preferences))
        applied = [one.in_world(world) for one in every]
        return frozenset[str]().union(*(one.avoided | one.closed for one in applied))

    def in_world(self, world: WorldFile, numbers: Numbers | None = None) -> "AppliedConstraints":
        """The constraints on the robots and places of this world, and those of its zones to keep out of."""
        areas = tuple(zone.name for zone in world.zones_of(ZoneRule.KEEP_OUT))
        of_robots = self.of_robots(world)
        kept = kept_things(self.keep, world)
        return AppliedConstraints(
            excluded=frozenset(
                robot.name for robot in world.robots if not of_robots._allows(robot.name, numbers)
            ).union(kept.robots),
            avoided=_places(self.avoid, world).union(world.kept_out),
            kept_empty=_places(self.keep_empty, world),
            kept_samples=kept.samples,
            kept_for=kept.places,
            words=(*self.words, *((f"keeping out of {joined(areas, last='and')}",) if areas else ())),
        )

    def stages_of(self, goals: Sequence[Fact]) -> dict[Fact, int]:
        """The stage of each goal; empty if all are pursued together."""
        stages = dict(zip(goals, self.stages, strict=True)) if self.stages else {}
        return stages if len(set(stages.values())) > 1 else {}

    def preferences_in(
        self, world: WorldFile, permitted: Facts, numbers: Numbers | None = None
    ) -> tuple[PlannerPreference, ...]:
        """The preferences on the robots and places of this world.

        :param permitted: the facts that a plan may rest on by what is required.
        """
        return tuple(preference_in(preference, world, permitted, numbers) for preference in self.preferences)

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

    :param kept_samples: samples that are not moved.
    :param kept_for: where one of them is to lie: no other is put there.
    :param words: each constraint in words.
    """

    model_config = ConfigDict(frozen=True, ignored_types=(cached_property,))

    excluded: frozenset[str] = frozenset()
    avoided: frozenset[str] = frozenset()
    kept_empty: frozenset[str] = frozenset()
    kept_samples: frozenset[str] = frozenset()
    kept_for: frozenset[str] = frozenset()
    words: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.excluded or self.avoided or self.closed or self.kept_samples)

    @property
    def closed(self) -> frozenset[str]:
        """Where no sample is put."""
        return self.kept_empty | self.kept_for

    @property
    def names(self) -> frozenset[str]:
        """The robots, places and samples that plans do not use."""
        return self.excluded | self.avoided | self.closed | self.kept_samples

    def explaining(self, reason: str, conflict: Sequence[str] = ()) -> str:
        """A reason why there is no plan that names no constraints, with those under which it holds.

        :param conflict: those known to stand in the way, in words; none: all.
        """
        words = tuple(conflict) or self.words
        return f"{reason}, {joined(words, last='and')}" if words else reason

    @cached_property
    def withheld(self) -> Reservation:
        """What no plan may use."""
        return Reservation(robots=self.excluded, locations=self.avoided, samples=self.kept_samples)

    def within(self, others: Iterable["AppliedConstraints"]) -> "AppliedConstraints":
        """The same in the same words, with what others require, too."""
        every = [self, *others]
        sets = ("excluded", "avoided", "kept_empty", "kept_samples", "kept_for")
        return self.model_copy(
            update={name: frozenset[str]().union(*(getattr(one, name) for one in every)) for name in sets}
        )

    def withholds(self, fact: Fact) -> bool:
        """True if no plan may rest on the fact."""
        return is_withheld(fact, self.withheld) or (
            fact.predicate == VACANT and (fact.args[0] in self.kept_empty or fact.args[0] in self.kept_for)
        )

    def applied_to(self, facts: Facts) -> Facts:
        """The facts that a plan may rest on.

        NOTE: a place that is to be kept empty has no room; robots may still pass it, and samples may leave it.
        """
        return frozenset(fact for fact in facts if not self.withholds(fact)) if self else facts

    def broken_by(self, net: PlanNet) -> tuple[str, ...]:
        """How a plan-net breaks the constraints, in words; empty if it keeps them."""
        taken = taken_by(net)
        wrong = (
            ("uses", self.excluded & taken.robots),
            ("goes to", self.avoided & taken.locations),
            ("puts a sample in", self.closed & filled_by(net.actions)),
            ("moves", self.kept_samples & taken.samples),
        )
        return tuple(
            f"it {what} {joined(sorted(names, key=natural_key), last='and')}"
            for what, names in wrong
            if names
        )


NOTHING_WITHHELD = AppliedConstraints()


def preference_in(
    preference: StatedPreference, world: WorldFile, permitted: Facts, numbers: Numbers | None = None
) -> PlannerPreference:
    """A preference as the planner takes it."""
    return PlannerPreference(
        words=preference.words,
        cost_s=preference.cost_s,
        withheld=withheld_by(preference.constraint, world, permitted, numbers),
    )


def withheld_by(
    constraints: Constraints, world: WorldFile, permitted: Facts, numbers: Numbers | None = None
) -> frozenset[Fact]:
    """The facts that no plan that keeps the constraints rests on.

    NOTE: a place that is to be kept empty may become vacant only by the plan.

    :param permitted: the facts that a plan may rest on without them.
    """
    applied = constraints.in_world(world, numbers)
    vacant = frozenset(Fact(VACANT, (place,)) for place in applied.kept_empty)
    return (permitted - applied.applied_to(permitted)) | vacant


def check_constraints(
    constraints: Constraints, goals: Sequence[SymbolicFact], world: WorldFile, facts: Facts
) -> tuple[GoalIssue, ...]:
    """The issues with constraints on these goals: unknown names, and contradictions to a goal or a fact."""
    every = (constraints, *constraints.preferences)
    count = (
        len(constraints.after)
        + len(constraints.keep)
        + sum(len(names) for one in every for names in (one.robots, one.without, one.avoid, one.keep_empty))
    )
    if len(constraints.preferences) > MAX_PREFERENCES:
        detail = f"{len(constraints.preferences)} preferences are more than the {MAX_PREFERENCES} that a goal may have"
        return (GoalIssue(code="too-many-preferences", kind="invalid", detail=detail),)
    if count > MAX_NAMES:
        detail = f"{count} names are more than the {MAX_NAMES} that constraints may have"
        return (GoalIssue(code="too-many-names", kind="invalid", detail=detail),)
    unknown = (
        *(issue for one in every for issue in _unknown_names(one, world)),
        *unknown_in(constraints.keep, world),
    )
    return unknown or tuple(dict.fromkeys(_contradictions(constraints, goals, world, facts)))


def _unknown_names(constraints: _OnRobotsAndPlaces, world: WorldFile) -> Iterator[GoalIssue]:
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
    stated = constraints.keep
    constraints = constraints.without_achieved(goals, world)
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
            choices=tuple(sorted((robot.name for robot in world.robots), key=natural_key)),
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
    yield from _against_kept(stated, constraints.keep, goals, world, facts)
    for place in sorted(applied.kept_empty, key=natural_key):
        if there := remaining_samples(place, goals, world, facts):
            yield GoalIssue(
                code="place-occupied",
                kind="conflict",
                detail=f"{place} is to be kept empty, but {joined(there, last='and')} lies there",
                thing=place,
            )


def _against_kept(
    stated: Sequence[HoldFact],
    left: Sequence[HoldFact],
    goals: Sequence[SymbolicFact],
    world: WorldFile,
    facts: Facts,
) -> Iterator[GoalIssue]:
    """The issues with facts to keep: goals that end them, facts that cannot be true together, or are not true.

    :param left: those that no goal brings about.
    """
    for index, kept in enumerate(stated):
        thing = kept.args[0]
        for goal in goals:
            if contradicts(goal, kept, world):
                yield _contradicted(f"{goal} ends that {kept.words}, which is to be kept", thing)
        for other in stated[:index]:
            if contradicts(other, kept, world):
                yield _contradicted(f"{other.words} and {kept.words} cannot be kept together", thing)
    for kept in left:
        if not is_kept_true(kept, world, facts):
            yield GoalIssue(
                code="fact-not-true",
                kind="conflict",
                detail=f"{kept.words} is to be kept, but {believed_now(kept, facts)}",
                thing=kept.args[0],
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
