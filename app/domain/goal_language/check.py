"""Checks of structured goals against a world and its facts, before anything is planned."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from app.domain.goal_language.berth_choice import remaining_samples, resolve_berths
from app.domain.goal_language.conflict_set import smallest_conflict
from app.domain.goal_language.constraints import AppliedConstraints, Constraints, check_constraints
from app.domain.goal_language.issues import TOO_TIGHT, GoalIssue, unknown_name
from app.domain.goal_language.reachability import chain_from, crews_for, free_for, lacking_crew, reachers
from app.domain.goal_language.roles import unknown_robot
from app.domain.goal_language.words import choices_for, joined, natural_key
from app.domain.world_model.beliefs import IN, NEAR, Facts, place_of
from app.domain.world_model.berths import berths_of
from app.domain.world_model.problem import ROBOT, objects_of
from app.domain.world_model.vocabulary import planner_fact
from planner import KnowledgeBase, KnowledgeBaseError, number_words
from robots.wire import SymbolicFact
from robots.world import WorldFile

__all__ = ["GoalIssue", "blocking", "check_goals", "check_request", "preference_conflicts"]

MOST_TRIES = 100
"""So many sets of constraints are tried, a few milliseconds each, for a smaller set than the first that conflicts."""


def check_goals(
    goals: Sequence[SymbolicFact], world: WorldFile, facts: Facts, knowledge_base: KnowledgeBase
) -> tuple[GoalIssue, ...]:
    """All issues with the goals, in their order."""
    if not goals:
        return (GoalIssue(code="goal-needed", kind="invalid", detail="no goal is stated"),)
    berths = resolve_berths(goals, world, facts)
    known = [goal for goal in berths.values() if goal is not None]
    issues = [
        issue
        for stated, goal in berths.items()
        for issue in (
            _no_berth(stated, goals, world, facts)
            if goal is None
            else _check(goal, known, world, facts, knowledge_base)
        )
    ]
    issues.extend(_clashes(known))
    return tuple(dict.fromkeys(issues))


def check_request(
    goals: Sequence[SymbolicFact],
    constraints: Constraints,
    world: WorldFile,
    facts: Facts,
    knowledge_base: KnowledgeBase,
) -> tuple[GoalIssue, ...]:
    """All issues with the goals and the constraints on them. Conflicts of a goal after a mission are notes."""
    goals, constraints = constraints.of_goals(goals, world)
    issues = _issues_now(goals, constraints, world, facts, knowledge_base)
    if constraints.after:
        return tuple(replace(one, kind="note") if one.kind == "conflict" else one for one in issues)
    return issues


def _issues_now(
    goals: Sequence[SymbolicFact],
    constraints: Constraints,
    world: WorldFile,
    facts: Facts,
    knowledge_base: KnowledgeBase,
) -> tuple[GoalIssue, ...]:
    issues = check_goals(goals, world, facts, knowledge_base)
    if len(set(constraints.stages)) > 1:
        issues = tuple(map(_at_the_end, issues))
    if not (constraints or world.kept_out) or any(issue.kind == "invalid" for issue in issues):
        return issues
    against = (
        *_unknown_quantities(constraints, knowledge_base),
        *check_constraints(constraints, goals, world, facts),
    )
    if against or blocking(issues):
        return (*against, *issues)

    def limited(by: AppliedConstraints) -> tuple[GoalIssue, ...]:
        return blocking(check_goals(goals, world, by.applied_to(facts), knowledge_base))

    def conflict(parts: Sequence[Constraints]) -> bool:
        return bool(limited(Constraints.all_of(parts).in_world(world)))

    constraints = constraints.without_achieved(goals, world)
    if not limited(constraints.in_world(world)):
        return issues
    blamed = smallest_conflict(constraints.parts, conflict, tries=MOST_TRIES)
    applied = Constraints.all_of(blamed).in_world(world)
    withheld = tuple(sorted(applied.names, key=natural_key))
    tight = tuple(
        GoalIssue(
            code=TOO_TIGHT,
            kind="conflict",
            detail=applied.explaining(issue.detail),
            thing=issue.thing,
            choices=withheld,
            constraints=tuple(word for part in blamed for word in part.words),
        )
        for issue in limited(applied)
    )
    return (*issues, *tight)


def preference_conflicts(
    goals: Sequence[SymbolicFact],
    constraints: Constraints,
    world: WorldFile,
    facts: Facts,
    knowledge_base: KnowledgeBase,
) -> tuple[str, ...]:
    """For each preference why no plan can keep it; empty if one may, the goals being possible without any."""
    goals, constraints = constraints.of_goals(goals, world)
    required = constraints.model_copy(update={"preferences": ()})
    issues = (
        blocking(_issues_now(goals, required.and_also(preference.constraint), world, facts, knowledge_base))
        for preference in constraints.preferences
    )
    return tuple(found[0].detail if found else "" for found in issues)


def _unknown_quantities(constraints: Constraints, knowledge_base: KnowledgeBase) -> Iterator[GoalIssue]:
    known = [
        name for name, spec in knowledge_base.quantities.items() if tuple(spec.arguments.values()) == (ROBOT,)
    ]
    every = (constraints, *constraints.preferences)
    for quantity, number in (item for one in every for item in one.at_least.items()):
        if quantity not in known:
            yield unknown_name("quantity", quantity, known)
        elif not (spec := knowledge_base.quantities[quantity]).admits(number):
            detail = f"at_least: {quantity} is {spec.range_words}, not {number_words(number)}"
            yield GoalIssue(code="out-of-range", kind="invalid", detail=detail, thing=quantity)


def _at_the_end(issue: GoalIssue) -> GoalIssue:
    """The issue, with what stages do not change: all goals must hold at the end."""
    if issue.code not in {"one-thing-in-two-places", "two-goals-for-one-place"}:
        return issue
    hint = "all goals must be true at the end; state the later one when the mission for the first has ended"
    return replace(issue, detail=f"{issue.detail}: {hint}")


def blocking(issues: Sequence[GoalIssue]) -> tuple[GoalIssue, ...]:
    """The issues except notes."""
    return tuple(issue for issue in issues if issue.kind != "note")


def _check(
    goal: SymbolicFact,
    goals: Sequence[SymbolicFact],
    world: WorldFile,
    facts: Facts,
    knowledge_base: KnowledgeBase,
) -> Iterator[GoalIssue]:
    unknown = list(_unknown_names(goal, world))
    yield from unknown
    if not unknown:
        malformed = list(_malformed(goal, world, knowledge_base))
        yield from malformed
        if not malformed:
            yield from _against_facts(goal, goals, world, facts, knowledge_base)


def _unknown_names(goal: SymbolicFact, world: WorldFile) -> Iterator[GoalIssue]:
    """Names that the world does not have, in goals about a sample or robot and a place."""
    samples = tuple(sorted((sample.name for sample in world.samples), key=natural_key))
    robots = tuple(sorted((robot.name for robot in world.robots), key=natural_key))
    places = tuple(sorted(world.places_by_location, key=natural_key))
    if len(goal.args) != 2 or goal.predicate not in {IN, NEAR, "at"}:
        return
    subject, place = goal.args
    if goal.predicate == IN and subject not in samples:
        yield unknown_name("sample", subject, samples)
    if goal.predicate != IN and subject not in robots:
        yield unknown_robot(subject, world)
    if (
        place not in places
        and place not in world.location_of
        and not (goal.predicate == IN and place in robots)
    ):
        holding = tuple(name for name in places if world.location(name).capacity > 0)
        yield unknown_name("place", place, holding if goal.predicate == IN else places)


def _malformed(goal: SymbolicFact, world: WorldFile, knowledge_base: KnowledgeBase) -> Iterator[GoalIssue]:
    """Goals that are not in the vocabulary, or are no plan-net action's intended effect."""
    choices = knowledge_base.relation_names()
    try:
        fact = planner_fact(goal, knowledge_base, objects_of(world))
    except KnowledgeBaseError as error:
        unknown = goal.predicate not in choices
        yield GoalIssue(
            code="unknown-predicate" if unknown else "malformed-goal",
            kind="invalid",
            detail=f"there is no predicate {goal.predicate!r}" if unknown else str(error),
            thing=goal.predicate,
            choices=choices_for(goal.predicate, choices) if unknown else (),
        )
        return
    intended = {
        literal.predicate for operator in knowledge_base.operators for literal in operator.intended_effects
    }
    if fact.predicate not in intended:
        yield GoalIssue(
            code="goal-not-intended",
            kind="invalid",
            detail=f"no action has {goal} as an intended effect",
            thing=goal.predicate,
            choices=tuple(sorted(intended)),
        )


def _against_facts(
    goal: SymbolicFact,
    goals: Sequence[SymbolicFact],
    world: WorldFile,
    facts: Facts,
    knowledge_base: KnowledgeBase,
) -> Iterator[GoalIssue]:
    wanted = planner_fact(goal, knowledge_base, objects_of(world))
    if wanted in facts and not knowledge_base.achieved_each_time([wanted]):
        yield GoalIssue(
            code="already-true", kind="note", detail=f"{goal} is true already", thing=goal.args[0]
        )
    elif goal.predicate == IN and goal.args[1] in world.location_of:
        yield from _storing(goal.args[0], goal.args[1], goals, world, facts)
    elif goal.predicate == NEAR:
        yield from _standing(goal.args[0], goal.args[1], facts)


def _storing(
    sample: str, place: str, goals: Sequence[SymbolicFact], world: WorldFile, facts: Facts
) -> Iterator[GoalIssue]:
    """Issues with a goal that a sample lies in a location."""
    if world.location(place).capacity == 0:
        yield GoalIssue(
            code="place-holds-no-samples",
            kind="invalid",
            detail=f"{place} holds no samples",
            thing=place,
            choices=free_for(sample, world, facts),
        )
        return
    if there := [other for other in remaining_samples(place, goals, world, facts) if other != sample]:
        yield GoalIssue(
            code="place-occupied",
            kind="conflict",
            detail=f"{place} is occupied by {joined(there, last='and')}",
            thing=place,
            choices=free_for(sample, world, facts),
        )
    yield from _reachable(sample, place, world, facts)


def _no_berth(
    goal: SymbolicFact, goals: Sequence[SymbolicFact], world: WorldFile, facts: Facts
) -> Iterator[GoalIssue]:
    """The issue that each berth of the goal's location holds a sample that stays or is another goal's."""
    unknown = list(_unknown_names(goal, world))
    yield from unknown
    if unknown:
        return
    subject, name = goal.args
    berths = berths_of(name, world)
    named = {name, *berths}
    coming = sorted({g.args[0] for g in goals if g.args[1:] and g.args[1] in named}, key=natural_key)
    there = [sample for berth in berths for sample in remaining_samples(berth, goals, world, facts)]
    too_many = len(coming) > len(berths)
    others = [other for other in coming if other not in {subject, *there}]
    occupied = f"are occupied by {joined(there, last='and')}" if there else ""
    wanted = f"are wanted for {joined(others, last='and')}" if others else ""
    words = " and ".join(part for part in (occupied, wanted) if part)
    choices = tuple(other for other in free_for(subject, world, facts) if other != name)
    yield GoalIssue(
        code="place-occupied",
        kind="invalid" if too_many else "conflict",
        detail=f"{name} has no room for {subject}: its {len(berths)} berths {words}",
        thing=name,
        choices=choices,
    )


def _reachable(sample: str, place: str, world: WorldFile, facts: Facts) -> Iterator[GoalIssue]:
    """Issues unless a crew for the sample reaches the place, and a chain of crews can bring the sample to it."""
    if (lacking := lacking_crew(sample, world, facts)) is not None:
        yield GoalIssue(code="too-few-robots", kind="conflict", detail=lacking, thing=sample)
        return
    crews = crews_for(sample, world, facts)
    if not reachers(place, crews):
        yield GoalIssue(
            code="place-unreachable",
            kind="conflict",
            detail=f"no robot that can carry samples reaches {place}",
            thing=place,
        )
        return
    lies = place_of(sample, facts)
    if lies is None:
        yield GoalIssue(
            code="sample-lost", kind="conflict", detail=f"it is not known where {sample} is", thing=sample
        )
        return
    reached = chain_from(lies, facts, crews)
    if place not in reached:
        choices = tuple(
            sorted({world.location_of.get(name, name) for name in reached - {lies}}, key=natural_key)
        )
        yield GoalIssue(
            code="no-chain-of-robots",
            kind="conflict",
            detail=f"no chain of robots can hand {sample} from {lies} to {place}",
            thing=place,
            choices=choices,
        )


def _standing(robot: str, place: str, facts: Facts) -> Iterator[GoalIssue]:
    """Issues with a goal that a robot stands near a location."""
    reached = tuple(
        sorted((f.args[1] for f in facts if f.predicate == "reaches" and f.args[0] == robot), key=natural_key)
    )
    if place not in reached:
        yield GoalIssue(
            code="place-unreachable",
            kind="invalid",
            detail=f"{robot} does not reach {place}",
            thing=place,
            choices=reached,
        )


def _clashes(goals: Sequence[SymbolicFact]) -> Iterator[GoalIssue]:
    """Goals that cannot be true together: two samples for one place, one thing in two places."""
    pairs = [(g.predicate, *g.args) for g in goals if g.predicate in {IN, NEAR} and len(g.args) == 2]
    for place, things in _grouped((place, thing) for predicate, thing, place in pairs if predicate == IN):
        yield GoalIssue(
            code="two-goals-for-one-place",
            kind="invalid",
            detail=f"{place} cannot hold {joined(things, last='and')} at once",
            thing=place,
        )
    for thing, places in _grouped((thing, place) for _, thing, place in pairs):
        yield GoalIssue(
            code="one-thing-in-two-places",
            kind="invalid",
            detail=f"{thing} cannot be in {joined(places, last='and')} at once",
            thing=thing,
        )


def _grouped(pairs: Iterable[tuple[str, str]]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The keys that come with more than one value, with their values."""
    values: dict[str, dict[str, None]] = defaultdict(dict)
    for key, value in pairs:
        values[key][value] = None
    return ((key, tuple(found)) for key, found in values.items() if len(found) > 1)
