"""The planning problem that a goal poses now: what is believed, what is free, what was learned, what is urgent."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.durations import Durations, Kind
from app.domain.errors import Conflict
from app.domain.goal_language.check import blocking, check_goals
from app.domain.world_model import initial_spots, objects_of, planning_problem, spot_of
from app.domain.world_model.beliefs import CAN
from app.domain.world_model.reservation import is_withheld
from app.domain.world_model.vocabulary import planner_fact
from app.planning.berth_aims import with_chosen_berths
from app.store import GoalRow, WorldRow
from app.store.durations import learned_durations
from app.store.records import lost_robot_reasons
from app.store.reservations import MissionReservation, all_reserved
from planner import Fact, KnowledgeBase, PlanningProblem, scale_term
from planner.bounds.contradiction import contradicting_goals
from planner.explanation.diagnosis import why_unsolvable
from planner.relaxation import is_relaxed_reachable
from robots.clock import Clock
from robots.wire import SymbolicFact
from robots.world import WorldFile

MOST_LOOKED_INTO = 8
"""Of more missions and robots it is not found out which of them a goal waits for."""

Points = Callable[[str], Mapping[str, tuple[float, float]]]
"""Where the robots of a world last said they are, (x, y) in metres; those that have not are where its file says."""
Resting = Callable[[str], Mapping[str, str]]
"""The robots of a world that are not recruited now, each with the reason."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalProblem:
    """A goal's planning problem, and what it was posed from.

    :param whole: the problem if nothing were reserved and no robot rested.
    :param refusal: why the goal makes no sense in the world as it is by now; empty if it does.
    :param factors: what durations are scaled by, by action and team size.
    :param releases: how often something had become free in the world by then.
    """

    problem: PlanningProblem
    whole: PlanningProblem
    refusal: str
    held: Sequence[MissionReservation]
    resting: Mapping[str, str]
    factors: Mapping[Kind, float]
    world_version: int
    releases: int

    @property
    def waits_for(self) -> str:
        """The missions and robots that a goal without a plan may wait for, in words; empty if there are none."""
        missions = [str(mission) for mission in self.held]
        robots = [f"{robot}, {why}" for robot, why in sorted(self.resting.items())]
        return " and ".join((*missions, *robots))

    def why_never(self, knowledge_base: KnowledgeBase) -> str:
        """Why the goal would have no plan either if all of them were free, in words; empty if it may have one."""
        if not _is_hopeless(knowledge_base, self.whole):
            return ""
        return why_unsolvable(knowledge_base, self.whole)

    def without(self, robots: Collection[str]) -> "GoalProblem":
        """The same, with robots that are not waited for."""
        facts = frozenset(fact for fact in self.whole.facts if not _is_ability(fact, of=robots))
        resting = {robot: why for robot, why in self.resting.items() if robot not in robots}
        return replace(self, whole=replace(self.whole, facts=facts), resting=resting)

    def narrowed(self, knowledge_base: KnowledgeBase) -> "GoalProblem":
        """Waiting only for those missions and robots of which each alone keeps the goal out of reach; for all of
        them where none does so alone, or where they are too many to look into."""
        if len(self.held) + len(self.resting) > MOST_LOOKED_INTO:
            return self

        def blocks(withheld: Callable[[Fact], bool]) -> bool:
            left = frozenset(fact for fact in self.whole.facts if not withheld(fact))
            return _is_hopeless(knowledge_base, replace(self.whole, facts=left))

        held = [one for one in self.held if blocks(partial(is_withheld, reserved=one.reservation))]
        resting = {
            robot: why for robot, why in self.resting.items() if blocks(partial(_is_ability, of={robot}))
        }
        return replace(self, held=held, resting=resting) if held or resting else self


def _is_hopeless(knowledge_base: KnowledgeBase, problem: PlanningProblem) -> bool:
    """True if it is proven, quickly, that the problem has no plan."""
    return not is_relaxed_reachable(knowledge_base, problem) or bool(
        contradicting_goals(knowledge_base, problem)
    )


def _is_ability(fact: Fact, *, of: Collection[str]) -> bool:
    return fact.predicate == CAN and fact.args[0] in of


class ProblemBuilder:
    """Poses planning problems from the record."""

    def __init__(
        self,
        core: Core,
        *,
        worlds: Mapping[str, WorldFile],
        clocks: Mapping[str, Clock],
        points: Points,
        resting: Resting,
    ) -> None:
        self._facts, self._holdings, self._knowledge_base = core.facts, core.holdings, core.knowledge_base
        self._worlds, self._clocks, self._points, self._resting = worlds, clocks, points, resting

    def pose(self, session: Session, goal: GoalRow) -> GoalProblem:
        """What is to be planned for the goal now; what its own mission holds is at its disposal.

        :raises Conflict: if its world does not run.
        """
        if goal.world not in self._worlds:
            raise Conflict(f"world {goal.world} does not run", code="world-not-running")
        world = self._worlds[goal.world]
        facts = self._facts.facts(session, goal.world)
        held = [
            one for one in self._holdings.of_world(session, goal.world) if one.mission_id != goal.mission_id
        ]
        stated = [SymbolicFact.model_validate(fact) for fact in goal.goal]
        wanted = with_chosen_berths(session, goal, stated, world, facts, all_reserved(held))
        objects = objects_of(world)
        goals = tuple(planner_fact(fact, self._knowledge_base, objects) for fact in wanted)
        resting = {**self._resting(goal.world), **lost_robot_reasons(session, goal.world)}
        factors = factors_of(learned_durations(session, goal.world))
        said = {spot_of(robot): point for robot, point in self._points(goal.world).items()}
        spots, reserved = {**initial_spots(world), **said}, all_reserved(held)
        able = frozenset(fact for fact in facts if not _is_ability(fact, of=resting))
        problem = planning_problem(world, able, goals, spots=spots, reserved=reserved)
        issues = blocking(check_goals(stated, world, facts, self._knowledge_base))
        return GoalProblem(
            problem=self._urgent(_scaled(problem, factors), goal),
            whole=replace(problem, facts=facts),
            refusal="; ".join(issue.detail for issue in issues),
            held=held,
            resting=resting,
            factors=factors,
            world_version=self._facts.version(session, goal.world),
            releases=session.get_one(WorldRow, goal.world).releases,
        )

    def _urgent(self, problem: PlanningProblem, goal: GoalRow) -> PlanningProblem:
        """The problem with the goal's deadline, from now on, and its priority."""
        priorities: dict[Fact, int] = dict.fromkeys(problem.goals, goal.priority)
        if goal.deadline_at_s is None:
            return replace(problem, priorities=priorities)
        left_s = goal.deadline_at_s - self._clocks[goal.world].now_s()
        return replace(problem, priorities=priorities, deadlines_s=dict.fromkeys(problem.goals, left_s))


def factors_of(learned: Durations) -> Mapping[Kind, float]:
    """What the durations of each action and team size are to be scaled by."""
    return {kind: round(known.factor, 3) for kind, known in learned.items()}


def _scaled(problem: PlanningProblem, factors: Mapping[Kind, float]) -> PlanningProblem:
    scales = {scale_term(*kind): factor for kind, factor in factors.items()}
    return replace(problem, functions={**problem.functions, **scales})
