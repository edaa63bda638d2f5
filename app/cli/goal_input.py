"""Parses and checks goals given on the command line before anything starts."""

import re

from app.domain.errors import Invalid
from app.domain.goal_language.berth_choice import assign_berths
from app.domain.goal_language.check import blocking, check_goals
from app.domain.goal_language.grammar import Clarification, parse_goal
from app.domain.world_model import Facts
from planner import KnowledgeBase, KnowledgeBaseError
from planner.knowledge.literal import Literal
from robots.wire import SymbolicFact
from robots.world import WorldFile

FACT = re.compile(r"^\s*\w+\s*\(")
"""Matches a goal written as a fact, `near(yard_1, door_1)`."""


def parse_goals(
    world: WorldFile, facts: Facts, sentences: list[str], knowledge_base: KnowledgeBase
) -> list[SymbolicFact]:
    """The goals that sentences or facts state; a location with several berths is replaced by a free berth.

    :raises Invalid: if one is malformed, unknown or impossible in the world; names the thing and the choices.
    """
    goals: list[SymbolicFact] = []
    for sentence in sentences:
        if FACT.match(sentence):
            goals.append(_fact(sentence))
            continue
        parsed = parse_goal(sentence, world, facts)
        if isinstance(parsed, Clarification):
            raise Invalid(parsed.detail, code=parsed.code, choices=parsed.choices)
        goals.extend(parsed)
    for issue in blocking(check_goals(goals, world, facts, knowledge_base)):
        raise Invalid(issue.detail, code=issue.code, choices=issue.choices)
    return list(assign_berths(goals, world, facts))


def _fact(text: str) -> SymbolicFact:
    """:raises Invalid: if it is not of the form predicate(argument, …)."""
    try:
        literal = Literal.parse(text.strip())
    except KnowledgeBaseError as error:
        raise Invalid(str(error), code="malformed-goal") from error
    return SymbolicFact(predicate=literal.predicate, args=literal.terms)
