"""PDDL as knowledge base and planning problem."""

import re
import warnings
from collections.abc import Collection
from typing import Any

from planner.errors import Unsupported
from planner.interchange.foreign.up_reader import ReadProblem, read_up_problem
from planner.interchange.up_import import import_unified_planning
from planner.interchange.up_lock import UNIFIED_PLANNING_LOCK
from planner.knowledge import KnowledgeBaseFile

TOTAL_COST = "total-cost"
_COMMENT = re.compile(r";[^\n]*")
_DOMAIN = re.compile(r"\(\s*domain\s+([^\s()]+)", re.IGNORECASE)
_OF_DOMAIN = re.compile(r"\(\s*:domain\s+([^\s()]+)", re.IGNORECASE)
_ACTION = re.compile(r"^action (\S+?):")


def import_domain(domain: str, *, agents: Collection[str] = ()) -> KnowledgeBaseFile:
    """The knowledge base of a PDDL domain.

    :param agents: the types of agents; an action without them has its first parameter as its agent.
    :raises Unsupported: for what is no PDDL or does not fit; names the line, the feature and a workaround.
    """
    return _read(domain, None, agents).knowledge_base.file


def import_problem(domain: str, problem: str, *, agents: Collection[str] = ()) -> ReadProblem:
    """The knowledge base and the problem of a PDDL domain and problem; else as `import_domain`."""
    return _read(domain, problem, agents)


def _read(domain: str, problem: str | None, agents: Collection[str]) -> ReadProblem:
    _check_names(domain, problem)
    with UNIFIED_PLANNING_LOCK:
        import_unified_planning()
        from unified_planning.io import PDDLReader

        try:
            with warnings.catch_warnings():  # the reader uses deprecated calls of its parser
                warnings.simplefilter("ignore", DeprecationWarning)
                up_problem = PDDLReader().parse_problem_string(domain, problem)
        except RecursionError as error:
            raise Unsupported("this is no PDDL: brackets are nested too deeply") from error
        except Exception as error:  # NOTE: the reader raises errors of every kind, assertions among them
            raise Unsupported(f"this cannot be read as PDDL: {error or type(error).__name__}") from error
        try:
            _take_costs(up_problem)
            return read_up_problem(up_problem, agents=agents)
        except Unsupported as error:
            raise Unsupported(f"{_line(domain, str(error))}{error}") from error


def _check_names(domain: str, problem: str | None) -> None:
    """:raises Unsupported: if the problem is one of another domain."""
    own = _DOMAIN.search(_COMMENT.sub("", domain))
    meant = _OF_DOMAIN.search(_COMMENT.sub("", problem or ""))
    if own and meant and own[1].lower() != meant[1].lower():
        raise Unsupported(f"the problem is one of domain {meant[1]}, not of {own[1]}")


def _take_costs(up_problem: Any) -> None:
    """Make the increases of total-cost the actions' costs; the reader does so for some problems only."""
    from unified_planning.model.metrics import MinimizeActionCosts

    costs = {}
    for action in up_problem.actions:
        effects = getattr(action, "effects", ())
        paid = [e for e in effects if not isinstance(effects, dict) and _is_cost(e)]
        if len(paid) == 1:
            costs[action] = paid[0].value
            kept = [effect for effect in effects if effect is not paid[0]]
            action.clear_effects()
            for effect in kept:
                add = action.add_effect
                if effect.is_increase():
                    add = action.add_increase_effect
                elif effect.is_decrease():
                    add = action.add_decrease_effect
                add(effect.fluent, effect.value, effect.condition, effect.forall)
    if costs:
        up_problem.clear_quality_metrics()
        up_problem.add_quality_metric(MinimizeActionCosts(costs, 0, up_problem.environment))


def _is_cost(effect: Any) -> bool:
    return effect.is_increase() and not effect.is_conditional() and effect.fluent.fluent().name == TOTAL_COST


def _line(domain: str, message: str) -> str:
    """`line 12, ` if the message is about an action of the domain."""
    name = _ACTION.match(message)
    if name is None:
        return ""
    place = re.search(rf"\(\s*:(?:durative-)?action\s+{re.escape(name[1])}[\s)]", domain, re.IGNORECASE)
    return f"line {domain.count(chr(10), 0, place.start()) + 1}, " if place else ""
