"""Holds against a world: the goals that make true what they keep, their issues, and those of goals that they forbid."""

from collections.abc import Iterator, Sequence
from datetime import datetime

from app.domain.goal_language.berth_choice import remaining_samples
from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.constraints import UNCONSTRAINED, AppliedConstraints, Constraints
from app.domain.goal_language.issues import GoalIssue, unknown_name
from app.domain.goal_language.kept_facts import (
    contradicts,
    is_kept_true,
    kept_things,
    left_to_keep,
    unknown_in,
)
from app.domain.goal_language.reachability import free_for
from app.domain.goal_language.references import Aims, References, locations_aimed_at, no_aims
from app.domain.goal_language.sentence import Phrase
from app.domain.goal_language.stated_holds import StandingHold, StatedHold, kept_by, places_in
from app.domain.goal_language.terms import Reading
from app.domain.goal_language.words import joined, natural_key
from app.domain.world_model.beliefs import IN, VACANT, Facts, place_of
from app.domain.world_model.berths import berths_of
from app.domain.world_model.problem import objects_of
from app.domain.world_model.vocabulary import planner_fact
from planner import KnowledgeBase, KnowledgeBaseError
from robots.wire import SymbolicFact
from robots.world import WorldFile

MAX_HOLDS = 100
"""The most holds that one goal may state."""
LONGEST_S = 1e10
"""The longest span of a hold, some 300 years."""


def goals_of_holds(
    holds: Sequence[StatedHold],
    goals: Sequence[SymbolicFact],
    world: WorldFile,
    facts: Facts,
    within: Constraints,
    aims: Aims = no_aims,
) -> tuple[tuple[SymbolicFact, ...], tuple[Reading, ...]] | Clarification:
    """The goals that make true what holds keep: facts that are not true yet, and what leaves places to be empty.

    :param within: everything that limits where it may go.
    :param aims: called if something leaves a place: it goes to none that another goal aims at.
    """
    kept = [
        fact
        for fact in dict.fromkeys(fact for hold in holds for fact in hold.facts)
        if not any(unknown_in([fact], world)) and not is_kept_true(fact, world, facts)
    ]
    achieving = tuple(
        SymbolicFact(predicate=fact.predicate, args=fact.args) for fact in left_to_keep(kept, goals, world)
    )
    emptying = _emptying_goals(holds, [*goals, *achieving], world, facts, within, aims)
    if isinstance(emptying, Clarification):
        return emptying
    return (*achieving, *emptying[0]), emptying[1]


def _emptying_goals(
    holds: Sequence[StatedHold],
    goals: Sequence[SymbolicFact],
    world: WorldFile,
    facts: Facts,
    within: Constraints,
    aims: Aims,
) -> tuple[tuple[SymbolicFact, ...], tuple[Reading, ...]] | Clarification:
    """The goals that move what lies in places to be held elsewhere, unless one of the goals moves it.

    A sample goes to a free place of the same kind of location; if there is none, to any.

    :param within: everything that limits where it may go.
    """
    applied = within.and_also(kept_by(holds)).in_world(world)
    names = References(world=world, facts=facts, applied=applied)
    every = list(goals)
    readings = []
    for place in sorted(places_in((name for hold in holds for name in hold.places), world), key=natural_key):
        if place not in world.places_by_location and place not in world.location_of:
            continue  # `check_holds` refuses it
        for sample in remaining_samples(place, goals, world, facts):
            kind = world.location(world.location_of.get(place, place)).kind
            beside = [aim for aim in aims() if aim.predicate == IN]
            taken = locations_aimed_at([*every, *beside], sample, world)
            chosen = names.free_place(Phrase(), kind, sample, taken)
            if isinstance(chosen, Clarification):
                chosen = names.free_place(Phrase(), "", sample, taken)
            if isinstance(chosen, Clarification):
                return Clarification(
                    code="no-place-to-empty",
                    detail=f"{place} is to be kept empty, {sample} lies there, and {chosen.detail}",
                    thing=place,
                )
            every.append(SymbolicFact(predicate=IN, args=(sample, chosen)))
            readings.append(Reading(said=f"{place} is emptied", means=(f"{sample} to {chosen}",)))
    return tuple(every[len(goals) :]), tuple(readings)


def check_holds(
    holds: Sequence[StatedHold],
    world: WorldFile,
    facts: Facts,
    knowledge_base: KnowledgeBase,
    now: datetime,
) -> tuple[GoalIssue, ...]:
    """The issues with holds: unknown names, and ends that have come already."""
    if len(holds) > MAX_HOLDS:
        detail = f"{len(holds)} holds are more than the {MAX_HOLDS} that one goal may state"
        return (GoalIssue(code="too-many-holds", kind="invalid", detail=detail),)
    return tuple(_issues(holds, world, facts, knowledge_base, now))


def _issues(
    holds: Sequence[StatedHold],
    world: WorldFile,
    facts: Facts,
    knowledge_base: KnowledgeBase,
    now: datetime,
) -> Iterator[GoalIssue]:
    yield from unknown_in((fact for hold in holds for fact in hold.facts), world)
    known = list(dict.fromkeys((*world.places_by_location, *world.location_of)))
    for name in dict.fromkeys(name for hold in holds for name in hold.places):
        if name not in known:
            yield unknown_name("place", name, known)
    for hold in holds:
        until = hold.until
        if until.at is not None and until.at <= now:
            yield GoalIssue(
                code="hold-over", kind="invalid", detail=f"{until.words}: that time has passed", thing=""
            )
        if until.in_s is not None and until.in_s > LONGEST_S:
            detail = (
                f"a span of more than {LONGEST_S:.0f} s is no end; leave out `until` for a hold without end"
            )
            yield GoalIssue(code="hold-too-long", kind="invalid", detail=detail)
        if until.fact is None:
            continue
        try:
            if comes_true(until.fact, world, facts, knowledge_base):
                yield GoalIssue(
                    code="hold-over",
                    kind="conflict",
                    detail=f"{until.fact} is true already",
                    thing=next(iter(until.fact.args), ""),
                )
        except KnowledgeBaseError as error:
            yield GoalIssue(
                code="malformed-fact", kind="invalid", detail=str(error), thing=until.fact.predicate
            )


def comes_true(fact: SymbolicFact, world: WorldFile, facts: Facts, knowledge_base: KnowledgeBase) -> bool:
    """True if the fact is believed. Of a location with several berths: of one of them; that it is empty, of all.

    :raises planner.KnowledgeBaseError: if it does not fit the vocabulary.
    """
    objects = objects_of(world)
    berths = berths_of(fact.args[-1], world) if fact.args else ()
    stated = [
        planner_fact(
            SymbolicFact(predicate=fact.predicate, args=(*fact.args[:-1], place)), knowledge_base, objects
        )
        for place in berths or fact.args[-1:]
    ] or [planner_fact(fact, knowledge_base, objects)]
    return (all if fact.predicate == VACANT else any)(one in facts for one in stated)


def held_issues(
    goals: Sequence[SymbolicFact], holds: Sequence[StandingHold], world: WorldFile, facts: Facts
) -> tuple[GoalIssue, ...]:
    """The issues with goals that put something where holds keep places empty, or end a fact that they keep true."""
    if not holds:
        return ()
    goals, _ = UNCONSTRAINED.of_goals(goals, world)
    return (*_filling(goals, holds, world, facts), *_ending(goals, holds, world))


def standing_conflicts(
    stated: Sequence[StatedHold], standing: Sequence[StandingHold], world: WorldFile
) -> tuple[GoalIssue, ...]:
    """The issues with holds that keep something else than those which stand, whatever is true now."""
    kept = [fact for hold in stated for fact in hold.facts]
    empty = places_in(kept_by(stated).keep_empty, world)
    return (
        *_ending(kept, standing, world),
        *(
            _held("place-held", next(iter(places)), [hold], world)
            for hold in standing
            if (places := kept_things(kept, world).places & hold.places)
        ),
        *(
            _held("fact-held", fact.args[0], [hold], world)
            for hold in standing
            for fact in hold.facts
            if kept_things([fact], world).places & empty
        ),
    )


def _filling(
    goals: Sequence[SymbolicFact], holds: Sequence[StandingHold], world: WorldFile, facts: Facts
) -> Iterator[GoalIssue]:
    held = frozenset[str]().union(*(hold.places for hold in holds))
    left = AppliedConstraints(kept_empty=held).applied_to(facts)
    for goal in goals:
        if goal.predicate != IN or len(goal.args) != 2:
            continue
        sample, name = goal.args
        places = set(berths_of(name, world)) or {name}
        if not places <= held or place_of(sample, facts) in places:
            continue
        by = [hold for hold in holds if hold.places & places]
        yield _held("place-held", name, by, world, choices=free_for(sample, world, left), other="place")


def _ending(
    goals: Sequence[SymbolicFact], holds: Sequence[StandingHold], world: WorldFile
) -> Iterator[GoalIssue]:
    """The issues with goals that cannot be true while a hold keeps its facts."""
    for goal in goals:
        for hold in holds:
            if any(contradicts(goal, fact, world) for fact in hold.facts):
                yield _held("fact-held", goal.args[0], [hold], world)


def _held(
    code: str,
    thing: str,
    holds: Sequence[StandingHold],
    world: WorldFile,
    *,
    choices: Sequence[str] = (),
    other: str = "",
) -> GoalIssue:
    """The issue with what holds stand against, their ends and how to end them early.

    :param other: what else may be chosen.
    """
    ids = joined([hold.id for hold in holds], last="and")
    words = joined([hold.words for hold in holds], last="and")
    choose = f"choose another {other}, wait," if other else "wait,"
    return GoalIssue(
        code=code,
        kind="conflict",
        detail=f"hold {ids} keeps {words}; {choose} or end the hold: "
        f"POST /v1/worlds/{world.name}/holds/{holds[0].id}:end",
        thing=thing,
        choices=tuple(choices),
    )
