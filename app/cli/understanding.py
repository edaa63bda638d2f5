"""Goals given on the command line, understood and checked before anything is started."""

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
"""A goal as a fact, `near(yard_1, door_1)`, and not as a sentence."""


def understood(
    world: WorldFile, facts: Facts, sentences: list[str], knowledge_base: KnowledgeBase
) -> list[SymbolicFact]:
    """The goals that the sentences or facts state, with a berth for each location that has several.

    :raises Invalid: naming the thing and the choices, if they state none or the world stands against them.
    """
    wanted: list[SymbolicFact] = []
    for sentence in sentences:
        if FACT.match(sentence):
            wanted.append(_fact(sentence))
            continue
        parsed = parse_goal(sentence, world, facts)
        if isinstance(parsed, Clarification):
            raise Invalid(parsed.detail, code=parsed.code, choices=parsed.choices)
        wanted.extend(parsed)
    for issue in blocking(check_goals(wanted, world, facts, knowledge_base)):
        raise Invalid(issue.detail, code=issue.code, choices=issue.choices)
    return list(assign_berths(wanted, world, facts))


def _fact(text: str) -> SymbolicFact:
    """:raises Invalid: if it is not of the form predicate(argument, …)."""
    try:
        literal = Literal.parse(text.strip())
    except KnowledgeBaseError as error:
        raise Invalid(str(error), code="malformed-goal") from error
    return SymbolicFact(predicate=literal.predicate, args=literal.terms)
