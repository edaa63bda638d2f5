"""Parses and checks goals given on the command line before anything starts."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime

from app.domain.clock import SYSTEM_CLOCK
from app.domain.errors import Invalid
from app.domain.goal_language.berth_choice import assign_berths
from app.domain.goal_language.check import GoalIssue, blocking, check_request
from app.domain.goal_language.completion import span_of
from app.domain.goal_language.constraints import (
    MAX_WORTH,
    UNCONSTRAINED,
    Constraints,
    check_constraints,
)
from app.domain.goal_language.grammar import Clarification, Understood, understand
from app.domain.goal_language.hold_checks import check_holds, goals_of_holds
from app.domain.goal_language.stated_holds import HoldPreview, StatedHold, kept_by
from app.domain.goal_language.terms import Reading
from app.domain.goal_language.times import Due
from app.domain.goal_language.verbs import Verbs
from app.domain.world_model import Facts
from planner import KnowledgeBase, KnowledgeBaseError
from planner.knowledge.literal import Literal
from robots.wire import SymbolicFact
from robots.world import WorldFile

FACT = re.compile(r"^\s*\w+\s*\(")
"""Matches a goal written as a fact, `near(yard_1, door_1)`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StatedGoals:
    """What the sentences and facts of a command line ask for; goals name berths, not locations that have several.

    :param constraints: with what the holds keep, as far as no goal brings it about.
    :param holds: what a service would keep for other goals, too.
    """

    goals: Sequence[SymbolicFact]
    constraints: Constraints = UNCONSTRAINED
    due: Due | None = None
    readings: Sequence[Reading] = ()
    holds: Sequence[HoldPreview] = ()

    @property
    def nothing_to_do(self) -> str:
        """Why there is nothing to plan, in words; empty if there is."""
        if self.goals or not self.holds:
            return ""
        return (
            f"nothing to carry out: all is so already; a service {' and '.join(h.words for h in self.holds)}"
        )


def parse_goals(
    world: WorldFile, facts: Facts, sentences: list[str], knowledge_base: KnowledgeBase
) -> list[SymbolicFact]:
    """The goals that sentences or facts state, without the terms; as `read_goals`."""
    return list(read_goals(world, facts, sentences, knowledge_base).goals)


def read_goals(
    world: WorldFile,
    facts: Facts,
    sentences: Sequence[str],
    knowledge_base: KnowledgeBase,
    verbs: Verbs | None = None,
    optional: Sequence[str] = (),
) -> StatedGoals:
    """What sentences or facts ask for; a location with several berths is replaced by a free berth.

    :param optional: goals that may be left out, each as `VALUE: GOAL`.
    :param verbs: of the sentences; default: those that ship with Macta.
    :raises Invalid: if one is malformed, unknown or impossible in the world; names the thing and the choices.
    """
    valued = [_valued(one) for one in optional]
    worth: list[float | None] = [*(None for _ in sentences), *(value for value, _ in valued)]
    sentences = [*sentences, *(sentence for _, sentence in valued)]
    stated = [_stated(sentence, world, facts, verbs) for sentence in sentences]
    constraints = UNCONSTRAINED
    for one in stated:
        constraints = constraints.and_also(one.constraints).and_also(kept_by(one.holds))
    if len(sentences) > 1:
        stated = _together(sentences, stated, world, facts, verbs, constraints)
    goals = [goal for one in stated for goal in one.goals]
    stages = [stage for one in stated for stage in one.constraints.stages or (0,) * len(one.goals)]
    holds = [hold for one in stated for hold in one.holds]
    emptying, emptied = _emptying(holds, goals, world, facts, constraints)
    goals += emptying
    stages += [0] * len(emptying)
    values = [value for one, value in zip(stated, worth, strict=True) for _ in one.goals]
    values += [None] * len(emptying)
    constraints = constraints.model_copy(
        update={"stages": tuple(stages), "worth": tuple(values) if valued else ()}
    )
    dues = [one.due for one in stated if one.due is not None]
    if len(dues) > 1:
        raise Invalid("several goals state a deadline; say one", code="two-deadlines")
    for issue in _issues(goals, constraints, holds, world, facts, knowledge_base):
        raise Invalid(
            issue.detail,
            code=issue.code,
            choices=issue.choices,
            constraints=issue.constraints,
            thing=issue.thing,
            span=span_of(sentences[0], issue.thing) if len(sentences) == 1 else None,
        )
    of_robots, constraints = constraints.of_goals(goals, world)
    constraints = constraints.without_achieved(of_robots, world)
    return StatedGoals(
        goals=assign_berths(of_robots, world, facts, avoid=constraints.kept_off(world)),
        constraints=constraints,
        due=dues[0] if dues else None,
        readings=[*(reading for one in stated for reading in one.readings), *emptied],
        holds=[HoldPreview.of(hold, _now()) for hold in holds],
    )


def _valued(stated: str) -> tuple[float, str]:
    """The value and the sentence of an optional goal.

    :raises Invalid: if it has no value above 0.
    """
    value, _, sentence = stated.partition(":")
    try:
        worth = float(value)
    except ValueError:
        worth = 0.0
    if not (0 < worth <= MAX_WORTH and sentence.strip()):
        raise Invalid(
            f"--optional {stated!r}: say what the goal is worth, a number above 0, a colon, and the goal, "
            "as in '5: move sample_1 to bay_7'",
            code="value-needed",
        )
    return worth, sentence.strip()


def _together(
    sentences: Sequence[str],
    alone: Sequence[Understood],
    world: WorldFile,
    facts: Facts,
    verbs: Verbs | None,
    constraints: Constraints,
) -> list[Understood]:
    """The sentences, read within the constraints of all; "any bay" is none that another of them aims at.

    :param alone: each as it is read without the others.
    """
    stated: list[Understood] = []
    for index, sentence in enumerate(sentences):
        before = [goal for one in stated for goal in one.goals]
        after = [goal for one in alone[index + 1 :] for goal in _named(one)]
        stated.append(_stated(sentence, world, facts, verbs, constraints, (*before, *after)))
    return stated


def _named(understood: Understood) -> Sequence[SymbolicFact]:
    """The goals of a sentence without those whose place was chosen for it."""
    chosen = {name for reading in understood.readings for name in reading.means}
    return [goal for goal in understood.goals if goal.args and goal.args[-1] not in chosen]


def _emptying(
    holds: Sequence[StatedHold],
    goals: Sequence[SymbolicFact],
    world: WorldFile,
    facts: Facts,
    constraints: Constraints,
) -> tuple[Sequence[SymbolicFact], Sequence[Reading]]:
    """The goals that make true what is to be held, and how they were chosen."""
    found = goals_of_holds(holds, goals, world, facts, within=constraints)
    if isinstance(found, Clarification):
        raise found.refusal()
    return found


def _issues(
    goals: Sequence[SymbolicFact],
    constraints: Constraints,
    holds: Sequence[StatedHold],
    world: WorldFile,
    facts: Facts,
    knowledge_base: KnowledgeBase,
) -> Iterator[GoalIssue]:
    """What stands against the goals and holds, without notes."""
    yield from check_holds(holds, world, facts, knowledge_base, _now())
    if goals or not holds:
        yield from blocking(check_request(goals, constraints, world, facts, knowledge_base))
    else:
        yield from blocking(check_constraints(constraints, goals, world, facts))


def _stated(
    sentence: str,
    world: WorldFile,
    facts: Facts,
    verbs: Verbs | None,
    beside: Constraints = UNCONSTRAINED,
    other_goals: Sequence[SymbolicFact] = (),
) -> Understood:
    if FACT.match(sentence):
        return Understood(goals=(_fact(sentence),))
    understood = understand(
        sentence, world, facts, verbs=verbs, now=_now(), beside=beside, aims=lambda: other_goals
    )
    if isinstance(understood, Clarification):
        raise understood.refusal()
    return understood


def _now() -> datetime:
    return datetime.fromtimestamp(SYSTEM_CLOCK.epoch_s()).astimezone()


def _fact(text: str) -> SymbolicFact:
    """:raises Invalid: if it is not of the form predicate(argument, …)."""
    try:
        literal = Literal.parse(text.strip())
    except KnowledgeBaseError as error:
        raise Invalid(str(error), code="malformed-goal") from error
    return SymbolicFact(predicate=literal.predicate, args=literal.terms)
