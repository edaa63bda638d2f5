"""A second opinion: unified-planning's own validator on a linearisation of the plan-net."""

from typing import Any

from planner.compilation import UNIFIED_PLANNING_LOCK, CompiledProblem, up_constant, up_object, up_operator
from planner.knowledge import Operator
from planner.knowledge.base import binding_of
from planner.plan_net import PlanNet, PlanNetAction
from planner.validation import linearisation


def up_fault(compiled: CompiledProblem, plan_net: PlanNet) -> str | None:
    """What `SequentialPlanValidator` finds wrong, or None."""
    from unified_planning.engines.plan_validator import SequentialPlanValidator
    from unified_planning.engines.results import ValidationResultStatus
    from unified_planning.plans import SequentialPlan

    with UNIFIED_PLANNING_LOCK:
        steps = [_step(compiled, action) for action in linearisation(plan_net)]
        unmeasured = compiled.up_problem.clone()
        unmeasured.clear_quality_metrics()
        result = SequentialPlanValidator().validate(unmeasured, SequentialPlan(steps))
    if result.status is ValidationResultStatus.VALID:
        return None
    return (
        "; ".join(message.message for message in result.log_messages or ())
        or "the validator rejects the plan"
    )


def _step(compiled: CompiledProblem, action: PlanNetAction) -> Any:
    from unified_planning.plans import ActionInstance

    up_problem = compiled.up_problem
    op, binding = _operator(compiled, action)
    objects = [up_problem.object(_name(compiled, binding[name])) for name in op.parameters]
    expression = up_problem.environment.expression_manager.ObjectExp
    return ActionInstance(up_problem.action(up_operator(op)), tuple(map(expression, objects)))


def _operator(compiled: CompiledProblem, action: PlanNetAction) -> tuple[Operator, dict[str, str]]:
    for op in compiled.knowledge_base.operators:
        binding = binding_of(op, action.arguments) if op.spec.name == action.tag else None
        if binding is not None:
            return op, dict(binding)
    raise AssertionError(f"{action.tag} {dict(action.arguments)} is of no operator")


def _name(compiled: CompiledProblem, name: str) -> str:
    return up_object(name) if name in compiled.problem.objects else up_constant(name)
