"""Plan-nets judged by everybody who can judge them."""

from benchmarks.planner.check import fault_of
from benchmarks.planner.val_validation import is_installed, val_fault
from planner import KnowledgeBase, PlanNet, PlanningProblem, PlanningRequest, PlanningResult, PlanningStatus
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.interchange.up_validation import up_fault
from planner.plan_nets.plan_net import ROUNDING_S
from planner.plan_nets.validation import faults_of
from tests.planner.exploring import first_fault

EXPLORED = 16
"""Plan-nets of up to so many actions are carried out in every order of events."""
VAL_JUDGED = 24


def judged(plan_net: PlanNet, problem: PlanningProblem, base: KnowledgeBase) -> PlanNet:
    """The plan-net, if nobody finds a fault."""
    assert plan_net.goals == problem.goals
    assert faults_of(plan_net, problem.facts, base) == []
    assert fault_of(plan_net, problem, base) is None
    assert up_fault(base, problem, plan_net) is None
    count = len(plan_net.actions)
    if 0 < count <= VAL_JUDGED and is_installed():
        assert val_fault(base, problem, plan_net) is None
    if count <= EXPLORED:
        assert first_fault(plan_net, problem.facts, problem.objects, base) is None
    return plan_net


def honest(result: PlanningResult, problem: PlanningProblem, base: KnowledgeBase) -> PlanningResult:
    """The result, if it is a faultless plan-net or says why there is none."""
    assert (result.plan_net is not None) == (result.status is PlanningStatus.SOLVED)
    if result.plan_net is None:
        assert result.reason
        assert result.status is not PlanningStatus.FAILED
        return result
    judged(result.plan_net, problem, base)
    if result.lower_bound_s is not None:
        assert result.lower_bound_s <= result.plan_net.makespan_s + ROUNDING_S
    return result


def planned(base: KnowledgeBase, problem: PlanningProblem, request: PlanningRequest | None = None) -> PlanNet:
    """A faultless plan-net of the hierarchical engine."""
    result = HierarchicalEngine(base).plan(problem, request or PlanningRequest(effort_s=0.0))
    assert result.plan_net is not None, f"{result.status}: {result.reason}"
    honest(result, problem, base)
    return result.plan_net
