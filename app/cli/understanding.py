"""Goals given on the command line, understood and checked before anything is started."""

from app.errors import Invalid
from app.goals.berths import berthed
from app.goals.check import blocking, check_goals
from app.goals.grammar import Clarification, parse_goal
from app.world_model import Facts
from planner import KnowledgeBase
from robots.wire import SymbolicFact
from robots.world import WorldFile


def understood(
    world: WorldFile, facts: Facts, sentences: list[str], knowledge_base: KnowledgeBase
) -> list[SymbolicFact]:
    """The goals that the sentences state, with a berth for each location that has several.

    :raises Invalid: naming the thing and the choices, if they state none or the world stands against them.
    """
    wanted: list[SymbolicFact] = []
    for sentence in sentences:
        parsed = parse_goal(sentence, world, facts)
        if isinstance(parsed, Clarification):
            raise Invalid(parsed.detail, code=parsed.code, choices=parsed.choices)
        wanted.extend(parsed)
    for issue in blocking(check_goals(wanted, world, facts, knowledge_base)):
        raise Invalid(issue.detail, code=issue.code, choices=issue.choices)
    return list(berthed(wanted, world, facts))
