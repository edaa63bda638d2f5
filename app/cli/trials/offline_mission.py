"""From goals to scripts without a service: planned from the world's initial facts, and organised."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from app.domain.goal_language.constraints import UNCONSTRAINED, Constraints
from app.domain.mission_organiser import Library, Organised, load_library, organise
from app.domain.world_model import Facts, initial_facts, initial_spots, objects_of, planning_problem
from app.domain.world_model.numbers import Things, initial_numbers
from app.domain.world_model.senses import Perceives
from app.domain.world_model.vocabulary import planner_fact, symbolic_all
from planner import KnowledgeBase, PlanNet, PlanningEngine, PlanningProblem, PlanningRequest
from robots.wire import BehaviourScript, SymbolicFact
from robots.world import WorldFile


class NoMission(Exception):
    """Raised when goals cannot be planned or organised; the message says which and why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mission:
    """Goals turned into scripts."""

    world: WorldFile
    goals: Sequence[SymbolicFact]
    plan_net: PlanNet
    scripts: Sequence[BehaviourScript]


def goal_problem(
    world: WorldFile,
    facts: Facts,
    goals: Sequence[SymbolicFact],
    knowledge_base: KnowledgeBase,
    constraints: Constraints = UNCONSTRAINED,
    perceives: Perceives | None = None,
) -> PlanningProblem:
    """The planning problem of the goals; each names one place, not a location with several berths.

    :param perceives: what robots sense by their sensors that do not say what they sense; None: all.
    """
    objects = objects_of(world)
    wanted = tuple(planner_fact(goal, knowledge_base, objects) for goal in goals)
    numbers = Things.of(world).for_planner(initial_numbers(world, knowledge_base))
    known = (facts - knowledge_base.achieved_each_time(wanted)) | knowledge_base.compared(numbers)
    permitted = constraints.in_world(world, numbers).applied_to(known)
    problem = planning_problem(
        world,
        permitted,
        wanted,
        spots=initial_spots(world),
        knowledge_base=knowledge_base,
        perceives=perceives,
    )
    return replace(
        problem,
        stages=constraints.stages_of(wanted),
        values=constraints.values_of(wanted),
        preferences=constraints.preferences_in(world, permitted, numbers),
        numbers=numbers,
    )


def plan_mission(
    world: WorldFile,
    problem: PlanningProblem,
    engine: PlanningEngine,
    knowledge_base: KnowledgeBase,
    request: PlanningRequest,
    *,
    library: Library | None = None,
) -> Mission:
    """Plan and organise.

    :param library: default: the one of `store`.
    :raises NoMission: if one of the two fails.
    """
    result = engine.plan(problem, request)
    if result.plan_net is None:
        raise NoMission(f"{result.status}: {result.reason}")
    return organised_mission(world, result.plan_net, knowledge_base, library)


def organised_mission(
    world: WorldFile, plan_net: PlanNet, knowledge_base: KnowledgeBase, library: Library | None = None
) -> Mission:
    """Organise a plan-net.

    :param library: default: the one of `store`.
    :raises NoMission: if that fails.
    """
    repertoires = {robot.name: robot.repertoire for robot in world.robots}
    organised = organise(
        plan_net,
        library or load_library(knowledge_base),
        repertoires,
        "mission",
        knowledge_base,
        facts=initial_facts(world, knowledge_base),
        clearing=world.clearing,
    )
    if not isinstance(organised, Organised):
        raise NoMission(organised.reason)
    goals = symbolic_all(plan_net.goals, knowledge_base)
    return Mission(world=world, goals=goals, plan_net=plan_net, scripts=organised.scripts)
