"""What a problem leaves out because of missions, holds and robots that are not recruited, and work on such problems.

The work waits instead of failing if the problem would have a plan with what is withheld. This runs in a planning
process, for it takes as long as a small plan.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from app.domain.blockers import Blockers
from app.domain.goal_language.constraints import AppliedConstraints
from app.domain.world_model.beliefs import CAN, OPERABLE
from app.domain.world_model.reservation import Reservation, is_withheld
from app.planning.pool.work import Solutions, Work, WorkResult
from planner import Fact, KnowledgeBase, Observer, PlanningEngine, PlanningProblem, PlanningStatus
from planner.explanation.diagnosis import why_unsolvable
from planner.problem.choices import without_optional
from planner.problem.contradiction import contradicting_goals
from planner.relaxation import is_relaxed_reachable, unreachable_goals

MAX_BLOCKERS = 8
"""The most missions, holds and robots among which those that block a goal are determined."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Withheld:
    """What a problem leaves out; false if nothing.

    :param whole: the problem if nothing were withheld.
    :param missions: what other missions have reserved, by the mission in words.
    :param robots: the robots that are not recruited, each with the reason.
    :param tags: by robot, the packets that it is not recruited for though it has them; left out: all of it.
    :param holds: what each hold requires, by the hold's end in words.
    """

    whole: PlanningProblem
    missions: Mapping[str, Reservation]
    robots: Mapping[str, str]
    holds: Mapping[str, AppliedConstraints] = field(default_factory=dict)
    tags: Mapping[str, frozenset[str]] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.missions or self.robots or self.holds)

    def without(self, robots: Collection[str]) -> "Withheld":
        """The same without these robots, which are not waited for either."""
        facts = frozenset(fact for fact in self.whole.facts if not is_ability(fact, of=robots))
        others = {robot: why for robot, why in self.robots.items() if robot not in robots}
        return replace(self, whole=replace(self.whole, facts=facts), robots=others)

    def why_never(self, knowledge_base: KnowledgeBase) -> str:
        """Why there would be no plan even if nothing were withheld, in words; empty if there may be one."""
        return why_unsolvable(knowledge_base, self.whole) if _is_hopeless(knowledge_base, self.whole) else ""

    def blockers(self, knowledge_base: KnowledgeBase) -> Blockers:
        """The missions, holds and robots that each prevent a plan alone.

        All of them if none does so alone, or if there are more than `MAX_BLOCKERS`.
        """
        return self._those_that(lambda left: _is_hopeless(knowledge_base, left))

    def blockers_of_each(
        self, knowledge_base: KnowledgeBase, parts: Sequence[Collection[Fact]]
    ) -> Sequence[Blockers]:
        """Likewise for each of several goals of the problem; none of one that is out of reach if nothing is withheld.

        :param parts: each goal's facts. What is within reach is determined once for all of them.
        """
        if not (self and parts):
            return [Blockers()] * len(parts)
        goals = tuple(dict.fromkeys(fact for part in parts for fact in part))
        whole = replace(self, whole=replace(self.whole, goals=goals))
        never = {*unreachable_goals(knowledge_base, whole.whole)}
        out_of_reach: dict[frozenset[Fact], set[Fact]] = {}

        def blocks(left: PlanningProblem, part: Collection[Fact]) -> bool:
            if left.facts not in out_of_reach:
                out_of_reach[left.facts] = {*unreachable_goals(knowledge_base, left)}
            return not out_of_reach[left.facts].isdisjoint(part)

        return [
            whole._those_that(partial(blocks, part=part)) if never.isdisjoint(part) else Blockers()
            for part in parts
        ]

    def _those_that(self, blocks: Callable[[PlanningProblem], bool]) -> Blockers:
        """What alone prevents a plan.

        :param blocks: whether the problem has no plan from which only one mission's, hold's or robot's is withheld.
        """
        every = Blockers(missions=tuple(self.missions), holds=tuple(self.holds), robots=self.robots)
        if not 1 < len(self.missions) + len(self.holds) + len(self.robots) <= MAX_BLOCKERS:
            return every

        def without(withheld: Callable[[Fact], bool]) -> PlanningProblem:
            left = frozenset(fact for fact in self.whole.facts if not withheld(fact))
            return replace(self.whole, facts=left)

        alone = Blockers(
            missions=tuple(
                mission
                for mission, reserved in self.missions.items()
                if blocks(without(partial(is_withheld, reserved=reserved)))
            ),
            holds=tuple(hold for hold, kept in self.holds.items() if blocks(without(kept.withholds))),
            robots={
                robot: why
                for robot, why in self.robots.items()
                if blocks(without(partial(is_ability, of={robot}, tags=self.tags.get(robot))))
            },
        )
        return alone or every


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkUnlessBlocked:
    """Plan a problem from which something is withheld; without a plan, the result names what to wait for.

    :param problem: the problem, checked before the work; None if actions are under way that will change its facts.
    :param refusal: why the goal is impossible in the present world; then it is only determined whether to wait.
    """

    work: Work[Solutions]
    problem: PlanningProblem | None
    withheld: Withheld
    knowledge_base: KnowledgeBase
    refusal: str = ""

    def __call__(self, engine: PlanningEngine, observer: Observer) -> WorkResult[Solutions]:
        result: WorkResult[Solutions] = WorkResult(
            status=PlanningStatus.UNSOLVABLE, reason=self.refusal, is_refused=bool(self.refusal)
        )
        # What is out of reach is not given to the engine, which would explain in detail why: nobody reads that.
        if not self.refusal and not (self.problem and _is_hopeless(self.knowledge_base, self.problem)):
            result = self.work(engine, observer)
            if result.answer is not None:
                return result
        if not self.withheld:
            return result
        if never := self.withheld.why_never(self.knowledge_base):
            return WorkResult(status=PlanningStatus.UNSOLVABLE, reason=never)
        return replace(result, waits_for=self.withheld.blockers(self.knowledge_base))


def is_ability(fact: Fact, *, of: Collection[str], tags: Collection[str] | None = None) -> bool:
    """True if the fact says what one of these robots can.

    :param tags: only these packets; None: any.
    """
    if fact.predicate not in (CAN, OPERABLE) or fact.args[0] not in of:
        return False
    return tags is None or (fact.predicate == CAN and fact.args[1] in tags)


def _is_hopeless(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> bool:
    """True if it is proven, quickly, that the problem has no plan, even without its optional goals."""
    problem = without_optional(problem)
    return not is_relaxed_reachable(knowledge_base, problem) or bool(
        contradicting_goals(knowledge_base, problem)
    )
