"""Sequences from Fast Downward: for all goals at once, or for one goal after the other."""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from planner.engines.fast_downward.process import CHEAP, GREEDY, FastDownwardProcess, SequenceResult
from planner.fact import Fact
from planner.interchange.pddl import Form, PddlTask
from planner.knowledge import GroundAction, KnowledgeBase
from planner.native_process import Limits, never
from planner.plan_nets.extraction import fault_of
from planner.plan_nets.progression import progressed
from planner.problem.interface import PlanningProblem, PlanningStatus
from planner.problem.static_facts import StaticFacts

SECOND_TIME_S = 0.3
"""Time of the second configuration if the first has found a plan."""
SEARCH_TIME_S = 2.0
"""A search that takes longer than this is on a plateau; one goal at a time does better."""
SHARE = 0.25
"""The share of the time that is left that such a search takes at most: the others and improving follow."""


class Search:
    """Runs the searches; each ends at its limits or once `is_enough()`.

    :param programs: the folder that `find_programs` finds.
    """

    def __init__(
        self,
        programs: Path,
        knowledge_base: KnowledgeBase,
        limits: Limits,
        is_enough: Callable[[], bool] = never,
    ) -> None:
        self._programs = programs
        self._base = knowledge_base
        self._limits = limits
        self._is_enough = is_enough

    @property
    def is_over(self) -> bool:
        return self._limits.is_over or self._is_enough()

    def for_all_goals(self, problem: PlanningProblem, *, patient: bool = False) -> Iterator[SequenceResult]:
        """What each configuration finds for all the goals together; at least one answer.

        :param patient: divide all the time that is left among them.
        """
        left_s = self._limits.left_s
        time_s = left_s / 2 if patient else min(SEARCH_TIME_S, left_s * SHARE)
        task = PddlTask(self._base, problem, Form.CLASSICAL)
        with tempfile.TemporaryDirectory(prefix="macta-fd-") as folder:
            process = self._process(folder, task, self._limits)
            failure = process.translate()
            if failure is not None:
                yield failure
                return
            # A* on the costs first: it is stuck on a plateau less often than greedy search.
            cheap = process.search(CHEAP, time_s)
            yield cheap
            if cheap.status is not PlanningStatus.UNSOLVABLE:
                yield process.search(GREEDY, SECOND_TIME_S if cheap.sequence else time_s)

    def improve(
        self, problem: PlanningProblem, effort_s: float, take: Callable[[Sequence[GroundAction]], None]
    ) -> None:
        """Search for ever cheaper sequences, each taken as soon as it is found."""
        task = PddlTask(self._base, problem, Form.CLASSICAL)
        with tempfile.TemporaryDirectory(prefix="macta-fd-") as folder:
            limit_s = min(effort_s, self._limits.left_s)
            limits = Limits(limit_s, self._limits.clock, memory_mb=self._limits.memory_mb)
            process = self._process(folder, task, limits)
            if process.translate() is None:
                process.improve(take)

    def _process(self, folder: str, task: PddlTask, limits: Limits) -> FastDownwardProcess:
        return FastDownwardProcess(self._programs, Path(folder), task, limits, self._is_enough)

    def goal_by_goal(self, problem: PlanningProblem, statics: StaticFacts) -> SequenceResult:
        """A sequence that reaches one goal after the other, those that cannot be reached yet later."""
        state = problem.facts
        sequence = list[GroundAction]()
        achieved: list[Fact] = []
        waiting = list(problem.goals)
        while waiting:
            for goal in waiting:
                small = statics.for_goal(replace(problem, facts=state), goal, achieved)
                found = min(self.for_all_goals(small), key=_cost)
                if found.status is PlanningStatus.SOLVED:
                    break
            else:
                return found
            state = progressed(state, found.sequence)
            sequence += found.sequence
            achieved.append(goal)
            waiting.remove(goal)
        # A goal may have been undone by a later one, or reached by an effect not intended, which does not count.
        if (fault := fault_of(sequence, problem.facts, problem.goals)) is not None:
            return SequenceResult(status=PlanningStatus.NOT_FOUND, reason=fault)
        return SequenceResult(status=PlanningStatus.SOLVED, sequence=tuple(sequence))


def _cost(found: SequenceResult) -> tuple[bool, float]:
    """Sort key: solved ones first, then by the sum of durations."""
    return found.status is not PlanningStatus.SOLVED, sum(action.duration_s for action in found.sequence)
