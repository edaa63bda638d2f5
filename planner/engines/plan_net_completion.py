"""From an engine's sequence of actions to a checked plan-net."""

from collections.abc import Callable, Sequence

from planner.errors import InvalidPlan, KnowledgeBaseError, OrderNotKept
from planner.explanation.recruiting import recruitment_of
from planner.interchange.up_validation import up_fault
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_nets.assembly import assemble
from planner.plan_nets.extraction import extract
from planner.plan_nets.plan_net import PlanNet
from planner.plan_nets.synchronisation import keep_in_step
from planner.plan_nets.validation import faults_of, too_early, unjustified
from planner.problem.interface import (
    Objective,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.problem.static_facts import StaticFacts


def complete_plan_net(
    sequence: Sequence[GroundAction],
    problem: PlanningProblem,
    knowledge_base: KnowledgeBase,
    statics: StaticFacts,
) -> PlanNet | str:
    """The checked plan-net with what keeps each ordering, or the reason if an action is there for no intended effect,
    or brings about a goal too early or before one that it is to come after.

    :param sequence: of whole actions, of phases, or of both.

    :raises InvalidPlan: if the sequence does not reach the goals or the plan-net is faulty: an engine's or our
        own mistake.
    """
    phases = [phase for action in sequence for phase in knowledge_base.phases_of(action, problem.facts)]
    try:
        order = extract(phases, problem.facts, problem.goals, problem.stages, problem.after)
    except OrderNotKept as error:
        return str(error)
    recruitment = recruitment_of(order.actions, statics)
    plan_net = assemble(
        order,
        problem.goals,
        knowledge_base,
        recruitment,
        deadlines_s=problem.deadlines_s,
        not_before_s=problem.not_before_s,
    )
    if idle := unjustified(plan_net, knowledge_base):
        return idle[0]
    if early := too_early(plan_net):
        return early[0]
    if faults := faults_of(plan_net, problem.facts, knowledge_base):
        raise InvalidPlan("; ".join(faults))
    return keep_in_step(plan_net, problem.facts, problem.objects, knowledge_base, problem.senses)


def confirm(plan_net: PlanNet, problem: PlanningProblem, knowledge_base: KnowledgeBase) -> None:
    """Ask unified-planning's validator for a second opinion.

    :raises InvalidPlan: if it finds a fault.
    """
    if (fault := up_fault(knowledge_base, problem, plan_net)) is not None:
        raise InvalidPlan(f"unified-planning rejects the plan: {fault}")


def warm_up_validation(knowledge_base: KnowledgeBase) -> None:
    """Import unified-planning (1-2 s), which `confirm` needs."""
    empty = PlanningProblem(objects={}, facts=frozenset(), goals=())
    plan_net = complete_plan_net((), empty, knowledge_base, StaticFacts(knowledge_base, empty))
    assert isinstance(plan_net, PlanNet)
    confirm(plan_net, empty, knowledge_base)


def merit(plan_net: PlanNet, objective: Objective = Objective.MAKESPAN) -> tuple[float, ...]:
    """Quantities to minimise, most important first: the robots or the energy if these are the objective, then
    makespan, clearances, total work in seconds."""
    work_s = sum(action.duration_s for action in plan_net.actions)
    usual = plan_net.makespan_s, plan_net.clearances, work_s
    if objective is Objective.ROBOTS:
        return len(plan_net.robots), *usual
    if objective is Objective.ENERGY:
        return plan_net.energy_j, *usual
    return usual


Outcome = tuple[PlanningStatus, PlanNet | None, str]
"""How planning ended, the plan-net if there is one, else why there is none."""


def timed_result(
    engine: str,
    knowledge_base: KnowledgeBase,
    problem: PlanningProblem,
    request: PlanningRequest,
    plan: Callable[[], Outcome],
) -> PlanningResult:
    """The outcome of `plan` and its time; `FAILED` if the problem or its plan does not fit the knowledge base."""
    timer = request.timer()
    try:
        for fact in (*sorted(problem.facts), *problem.goals):
            knowledge_base.check(fact, problem.objects)
        outcome = plan()
    except (KnowledgeBaseError, InvalidPlan) as error:
        outcome = (PlanningStatus.FAILED, None, str(error))
    status, plan_net, reason = outcome
    return PlanningResult(
        status=status,
        engine=engine,
        planning_s=round(timer.elapsed_s, 4),
        plan_net=plan_net,
        reason=reason,
    )
