"""The work of a planning process for goals that wait: plan some of them together, and find what the others wait for."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from app.domain.blockers import Blockers
from app.planning.pool.withheld import Withheld
from app.planning.pool.work import PlanWork, Solution, WorkResult
from planner import Fact, KnowledgeBase, Observer, PlanningEngine, PlanningProblem, PlanningRequest
from planner.problem.contradiction import contradicting_goals
from planner.relaxation import unreachable_goals


@dataclass(frozen=True, slots=True, kw_only=True)
class Together:
    """What comes of goals that wait.

    :param solution: a plan for some of them together; None if there is none for two or more.
    :param joined: the goals that it achieves, by their place among all.
    :param waiting: likewise each goal that has no plan now and may have one later, with what it waits for.
    """

    solution: Solution | None = None
    joined: tuple[int, ...] = ()
    waiting: Mapping[int, Blockers]


@dataclass(frozen=True, slots=True, kw_only=True)
class JointWork:
    """Plan together as many goals as are within reach now.

    :param problem: with the facts of all goals as its goals.
    :param withheld: what it leaves out.
    :param parts: the facts of each goal, the most urgent goal first.
    :param at_most: so many goals.
    """

    knowledge_base: KnowledgeBase
    problem: PlanningProblem
    withheld: Withheld
    request: PlanningRequest
    parts: Sequence[tuple[Fact, ...]]
    at_most: int

    def __call__(self, engine: PlanningEngine, observer: Observer) -> WorkResult[Together]:
        out_of_reach = {*unreachable_goals(self.knowledge_base, self.problem)}
        within = [n for n, part in enumerate(self.parts) if out_of_reach.isdisjoint(part)]
        beyond = {n: part for n, part in enumerate(self.parts) if not out_of_reach.isdisjoint(part)}
        blockers = self.withheld.blockers_of_each(self.knowledge_base, list(beyond.values()))
        waiting = {n: one for n, one in zip(beyond, blockers, strict=True) if one}
        joined = self._compatible(within)
        while len(joined) > 1:
            found = PlanWork(problem=self._problem_of(joined), request=self.request)(engine, observer)
            if found.answer is not None and _has_actions(found.answer[0]):
                return WorkResult.solved(
                    Together(solution=found.answer[0], joined=tuple(joined), waiting=waiting)
                )
            joined = joined[: len(joined) // 2]
        return WorkResult.solved(Together(waiting=waiting))

    def _compatible(self, within: Sequence[int]) -> Sequence[int]:
        """The first of the goals that do not contradict each other."""
        chosen: list[int] = []
        for n in within:
            if len(chosen) == self.at_most:
                break
            if not contradicting_goals(self.knowledge_base, self._problem_of([*chosen, n])):
                chosen.append(n)
        return chosen

    def _problem_of(self, numbers: Collection[int]) -> PlanningProblem:
        goals = dict.fromkeys(fact for n in numbers for fact in self.parts[n])
        return replace(self.problem, goals=tuple(goals))


def _has_actions(solution: Solution) -> bool:
    net = solution.result.plan_net
    return net is not None and bool(net.actions)
