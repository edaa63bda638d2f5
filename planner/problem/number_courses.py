"""How numbers run while a plan-net is carried out, and where they leave what plans are to keep.

Actions change numbers evenly (`planner.knowledge.change`), by the plan-net's earliest starts; in between they fall by
their `drain`, which may depend on the action that is waited for. A battery thus falls by driving and by waiting for
others, and rises by charging. What a robot does once its part is done, such as to charge by itself, is no part of the
plan.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from planner.knowledge import KnowledgeBase
from planner.knowledge.comparison import SHARE, Term, value_words
from planner.plan_nets.plan_net import PlanNet, PlanNetAction
from planner.problem.interface import PlanningProblem

ROUNDING = 1e-6
LEAST_SHOWN = 0.0005
"""Half of the last digit in which shares are shown."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """A number at the start or end of an action that changes it.

    :param action: the index of that action in the plan-net.
    :param excess: by how much it is outside of what is kept; 0 or less: by how much inside.
    :param is_possible: it is within the quantity's range.
    """

    at_s: float
    value: float
    action: int
    excess: float
    is_possible: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """A number from the start of a plan-net to the end of the last action that changes it.

    :param points: in the order of time.
    :param raised_by: the actions that are there for it (`ActionSpec.until`), by index in the plan-net.
    :param excused: the points at actions before this index may be outside of what is kept.
    """

    term: Term
    start: float
    points: tuple[Point, ...]
    raised_by: tuple[int, ...] = ()
    excused: int = 0

    @property
    def end(self) -> float:
        return self.points[-1].value if self.points else self.start

    def before(self, action: int) -> float:
        """The number at the start of an action that changes it, by the action's index."""
        return next(point.value for point in self.points if point.action == action)

    def after(self, action: int) -> float:
        """The number at the end of such an action."""
        return next(point.value for point in reversed(self.points) if point.action == action)

    @property
    def excess(self) -> float:
        """How far it is outside of what is to be kept, at all points together."""
        return sum(point.excess for point in self.outside())

    def outside(self) -> Iterator[Point]:
        """The points at which it is outside of what is to be kept.

        If it is so from the start, it may be until it is brought back, if nothing is done before but going there.
        """
        for point in self.points:
            if point.excess > ROUNDING and (point.action >= self.excused or not point.is_possible):
                yield point


def courses(plan_net: PlanNet, problem: PlanningProblem, knowledge_base: KnowledgeBase) -> tuple[Course, ...]:
    """The courses of all numbers that plans keep within limits and that the plan-net changes, or that time does.

    Numbers that are not known have none.
    """
    kept = {name: spec for name, spec in knowledge_base.quantities.items() if spec.is_kept}
    if not any(quantity in kept for quantity, _ in problem.numbers):
        return ()
    changes: dict[Term, list[tuple[int, float]]] = {}
    for index, action in enumerate(plan_net.actions):
        for term, amount in knowledge_base.changed_numbers(action, problem.functions).items():
            if term in problem.numbers and term[0] in kept:
                changes.setdefault(term, []).append((index, amount))
    return tuple(
        _course(term, found, plan_net, problem, knowledge_base) for term, found in sorted(changes.items())
    )


def _course(
    term: Term,
    changes: Sequence[tuple[int, float]],
    plan_net: PlanNet,
    problem: PlanningProblem,
    knowledge_base: KnowledgeBase,
) -> Course:
    spec = knowledge_base.quantities[term[0]]
    value = problem.numbers[term]
    at_s = 0.0
    points: list[Point] = []
    raised_by: list[int] = []

    def note(action: int) -> None:
        excess, is_possible = excess_of(value, spec.kept), excess_of(value, spec.range) <= ROUNDING
        points.append(Point(at_s=at_s, value=value, action=action, excess=excess, is_possible=is_possible))

    for index, whole in changes:
        action, amount = plan_net.actions[index], whole
        if (waited_s := action.earliest_start_s - at_s) > 0:
            value -= waited_s * knowledge_base.drain_of(term, problem.functions, action)
        at_s = action.earliest_start_s
        note(index)
        aim = None if action.level is None else knowledge_base.aim_of(action)
        if aim is not None and aim[1] == term:
            raised_by.append(index)
            # It ends once the number is at its limit, however long it was to last.
            amount = _up_to(amount, aim[0].number - value)
        value += amount
        at_s = action.earliest_end_s
        note(index)
    return Course(
        term=term,
        start=problem.numbers[term],
        points=tuple(points),
        raised_by=tuple(raised_by),
        excused=_excused(changes, raised_by, plan_net, excess_of(problem.numbers[term], spec.kept)),
    )


def _excused(
    changes: Sequence[tuple[int, float]], raised_by: Sequence[int], plan_net: PlanNet, excess: float
) -> int:
    """The index of the action that brings back a number that is outside from the start, if only the way is before it:
    actions of one kind; else 0."""
    if excess <= ROUNDING or not raised_by:
        return 0
    way = {plan_net.actions[index].tag for index, _ in changes if index < raised_by[0]}
    return raised_by[0] + 1 if len(way) <= 1 else 0


def why_outside(
    course: Course, point: Point, actions: Sequence[PlanNetAction], knowledge_base: KnowledgeBase
) -> str:
    """`yard_1's battery is at 11 % at NAVIGATE(yard_1, …), and plans keep it at 20 % or more`"""
    quantity, args = course.term
    spec = knowledge_base.quantities[quantity]
    least, most = spec.kept
    limits = [
        *([] if least is None else [f"{value_words(least, spec.unit)} or more"]),
        *([] if most is None else [f"{value_words(most, spec.unit)} or less"]),
    ]
    # Not so close to the limit that it is read as the limit itself.
    shown = point.value - LEAST_SHOWN if spec.unit == SHARE else point.value
    said = f"{spec.words(quantity, args, shown)} at {actions[point.action].as_whole()}"
    return f"{said}, and plans keep it at {' and '.join(limits)}"


def _up_to(amount: float, left: float) -> float:
    """As much of a change as is left to a limit; none if the number is beyond it."""
    return max(0.0, min(amount, left)) if amount > 0 else min(0.0, max(amount, left))


def excess_of(value: float, bounds: tuple[float | None, float | None]) -> float:
    """By how much a value is outside of bounds."""
    least, most = bounds
    below = float("-inf") if least is None else least - value
    above = float("-inf") if most is None else value - most
    return max(below, above)
