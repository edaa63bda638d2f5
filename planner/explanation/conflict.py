"""Which constraints together leave no plan: the fewest found by leaving them out one by one.

A deletion filter (Chinneck & Dravnieks 1991): a constraint is left out for good if there is no plan without it either,
so that in the end each of those left is needed for the conflict.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from planner.fact import Fact
from planner.problem.interface import (
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.problem.solving import TimeLimitedEngine

WITHOUT_A_PLAN = frozenset(
    {
        PlanningStatus.UNSOLVABLE,
        PlanningStatus.NOT_FOUND,
        PlanningStatus.TIMED_OUT,
        PlanningStatus.OUT_OF_MEMORY,
    }
)
"""How planning ends where there seems to be no plan."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Restriction:
    """A constraint that may be left out.

    :param words: the constraint.
    :param withheld: no action of a plan that keeps it needs one of these facts.
    """

    words: str
    withheld: frozenset[Fact]


@dataclass(frozen=True, slots=True, kw_only=True)
class RestrictionConflict:
    """Constraints that seem to leave no plan together, in words.

    :param is_proven: an engine has proven that there is none; else none was found in the time given.
    :param is_complete: without any of them a plan was found; False if each could not be tried.
    """

    constraints: tuple[str, ...]
    is_proven: bool
    is_complete: bool


def conflict_among(
    problem: PlanningProblem,
    restrictions: Sequence[Restriction],
    status: PlanningStatus,
    engine: PlanningEngine,
    request: PlanningRequest,
    observer: Observer,
) -> RestrictionConflict | None:
    """The fewest of the restrictions found to leave no plan; None if there is none without all of them either.

    NOTE: what is not proven may be wrong: a plan may be missed in the time of a trial, and too much is left out then.

    :param problem: without any of the restrictions.
    :param status: how planning with all of them ended.
    :param request: its time limit is for all trials together, of which each gets an equal share of what is left.
    """
    planner = TimeLimitedEngine(engine, replace(request, effort_s=0.0), observer)
    left = len(restrictions) + 1

    def tried(some: Sequence[Restriction]) -> PlanningStatus:
        nonlocal left
        withheld = frozenset[Fact]().union(*(one.withheld for one in some))
        stated = replace(problem, facts=problem.facts - withheld)
        result = planner.plan(stated, at_most_s=planner.timer.left_s / left)
        left -= 1
        return PlanningStatus.NOT_FOUND if _breaks(result, withheld) else result.status

    if not restrictions or tried(()) is not PlanningStatus.SOLVED:
        return None
    kept = list(restrictions)
    is_complete = True
    for one in restrictions:
        others = [other for other in kept if other is not one]
        if not others:
            break  # it is the only one left, and without it there is a plan
        if planner.is_over:
            return _conflict(kept, status, is_complete=False)
        found = tried(others)
        if found in WITHOUT_A_PLAN:
            kept, status = others, found
        elif found is not PlanningStatus.SOLVED:
            is_complete = False
    return _conflict(kept, status, is_complete=is_complete)


def _breaks(result: PlanningResult, withheld: frozenset[Fact]) -> bool:
    """True if the plan first brings about what is withheld and then uses it: a place to keep empty that it empties."""
    return result.plan_net is not None and any(
        not withheld.isdisjoint(action.preconditions) for action in result.plan_net.actions
    )


def _conflict(
    kept: Sequence[Restriction], status: PlanningStatus, *, is_complete: bool
) -> RestrictionConflict:
    return RestrictionConflict(
        constraints=tuple(one.words for one in kept),
        is_proven=status is PlanningStatus.UNSOLVABLE,
        is_complete=is_complete,
    )
