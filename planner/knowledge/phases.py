"""Phases: an action whose literals name times within it, as a chain of actions that do not.

The times cut the action. Each phase needs what the action needs meanwhile, deletes at its start and has its effects at
its end, as any plan-net action; `under_way_…` facts chain them, so that a robot does them in turn and ends what it has
begun. Whatever orders, validates, executes or repairs plan-nets needs no further rule: a coupling rests on a phase as
on any action, and a robot that finds a place taken waits before the phase that needs it.

Our choices: an action that is too short for the times at its start and end stays whole, which asks for no less; if it
becomes so after it has begun, they are all shortened in proportion, so that they leave a tenth of it. A condition `at`
the start or end holds through the first or last phase. An action of several robots has no phases, since each would wait
for the other within it; nor has one of an agent for which the facts do not hold that it names (`phases_when`).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from planner.fact import Fact
from planner.knowledge.expression import Functions
from planner.knowledge.literal import Literal, ground_all
from planner.knowledge.operator import GroundAction, Operator
from planner.knowledge.timing import AT_END, AT_START, END, START, UNDER_WAY, Moment, Span

MOST = 0.9
"""The share of an action that the times at its start and end take at most together."""

_Interval = tuple[Moment, Moment]


def under_way_predicate(tag: str, phase: int) -> str:
    """The predicate that holds between a phase of an action and the next one."""
    return f"{UNDER_WAY}{tag.lower()}_{phase}"


@dataclass(frozen=True, kw_only=True)
class Phase(Operator):
    """One of an operator's phases, counted from 1."""

    whole: Operator
    number: int
    count: int
    share: "Share"

    def duration_s(self, binding: Mapping[str, str], functions: Functions) -> float | None:
        whole_s = self.whole.duration_s(binding, functions)
        return None if whole_s is None else self.share.seconds(whole_s)

    def exertion(
        self, binding: Mapping[str, str], functions: Functions, duration_s: float
    ) -> tuple[float, float]:
        """What falls to the phase by its share of the time."""
        whole_s = self.whole.duration_s(binding, functions) or 0.0
        distance_m, energy_j = self.whole.exertion(binding, functions, whole_s)
        part = self.share.seconds(whole_s) / whole_s if whole_s else 0.0
        return round(part * distance_m, 3), round(part * energy_j, 3)

    def ground(self, binding: Mapping[str, str], functions: Functions) -> GroundAction | None:
        action = super().ground(binding, functions)
        return None if action is None else replace(action, phase=self.number, phases=self.count)


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """The time of an action between two moments.

    `lead_s` and `tail_s`: what the action's times together ask for at its start and end.
    """

    begin: Moment
    end: Moment
    lead_s: float
    tail_s: float

    def fits(self, whole_s: float) -> bool:
        """Whether an action of this duration is long enough for its times."""
        return MOST * whole_s >= self.lead_s + self.tail_s

    def seconds(self, whole_s: float) -> float:
        """Of an action of this duration; the shares of all phases add up to it."""
        return round(self._at(self.end, whole_s) - self._at(self.begin, whole_s), 3)

    def _at(self, moment: Moment, whole_s: float) -> float:
        asked_s = self.lead_s + self.tail_s
        seconds = moment.seconds * (min(1.0, MOST * whole_s / asked_s) if asked_s else 1.0)
        return round(whole_s - seconds if moment.before_end else seconds, 3)


def ground_phases(
    action: GroundAction, phases: Sequence[Phase], binding: Mapping[str, str]
) -> tuple[GroundAction, ...]:
    """Phases of a ground action, all of one operator.

    What the action does not have from its operator (zones, doors) it needs throughout, except what it deletes at its
    start, and brings about at its end.
    """
    whole = phases[0].whole
    more_needs = _beyond(action.preconditions, whole.preconditions, binding)
    more_deletes = _beyond(action.deletes, whole.deletes, binding)
    more_effects = _beyond(action.effects, (*whole.intended_effects, *whole.other_effects), binding)
    kept = [fact for fact in more_needs if fact not in more_deletes]
    grounded = []
    for phase in phases:
        is_first, is_last = phase.number == 1, phase.number == phase.count
        seconds = phase.share.seconds(action.duration_s)
        part = seconds / action.duration_s if action.duration_s else 0.0
        grounded.append(
            replace(
                action,
                preconditions=(
                    *ground_all(phase.preconditions, binding),
                    *(more_needs if is_first else kept),
                ),
                deletes=(*ground_all(phase.deletes, binding), *(more_deletes if is_first else ())),
                intended_effects=ground_all(phase.intended_effects, binding),
                other_effects=(
                    *ground_all(phase.other_effects, binding),
                    *(more_effects if is_last else ()),
                ),
                duration_s=seconds,
                distance_m=round(part * action.distance_m, 3),
                energy_j=round(part * action.energy_j, 3),
                phase=phase.number,
                phases=phase.count,
            )
        )
    return tuple(grounded)


def _beyond(facts: Sequence[Fact], stated: Sequence[Literal], binding: Mapping[str, str]) -> list[Fact]:
    """The facts that no literal of the operator states."""
    own = ground_all(stated, binding)
    return [fact for fact in facts if fact not in own]


def phases_of(op: Operator) -> tuple[Phase, ...]:
    """The operator's phases; none if no time cuts it. Each needs what the operator has phases only with."""
    intervals = _intervals(op)
    if len(intervals) < 2 or len(op.agents) != 1:
        return ()
    moments = [moment for interval in intervals for moment in interval]
    lead_s = max(one.seconds for one in moments if not one.before_end)
    tail_s = max(one.seconds for one in moments if one.before_end)
    chain = [_chain(op, number) for number in range(1, len(intervals))]
    made = [
        Phase(
            name=f"{op.name}_phase_{number}",
            spec=op.spec,
            parameters=op.parameters,
            chosen=op.chosen,
            teams=op.teams,
            preconditions=(
                *chain[number - 2 : number - 1],
                *dict.fromkeys((*_needed(op, intervals, number - 1), *op.phases_when)),
            ),
            deletes=(*chain[number - 2 : number - 1], *_at(op, "delete", intervals, number - 1)),
            intended_effects=(
                *_at(op, "intended_effects", intervals, number - 1),
                *chain[number - 1 : number],
            ),
            other_effects=tuple(_at(op, "other_effects", intervals, number - 1)),
            duration=op.duration,
            distance=op.distance,
            energy=op.energy,
            waiting=op.waiting,
            whole=op,
            number=number,
            count=len(intervals),
            share=Share(begin=begin, end=end, lead_s=lead_s, tail_s=tail_s),
        )
        for number, (begin, end) in enumerate(intervals, start=1)
    ]
    return tuple(made)


def _intervals(op: Operator) -> list[_Interval]:
    """What the operator's times cut it into, in order; an effect at the start or a delete at the end takes no time."""
    moments = {START, END}
    for spans in op.spans.values():
        for span in spans.values():
            moments.update(span.moments)
    ordered = sorted(moments, key=lambda moment: moment.place)
    intervals = list(pairwise(ordered))
    effects = (*op.spans.get("intended_effects", {}).values(), *op.spans.get("other_effects", {}).values())
    if AT_START in effects:
        intervals.insert(0, (START, START))
    if AT_END in op.spans.get("delete", {}).values():
        intervals.append((END, END))
    return intervals


def _chain(op: Operator, number: int) -> Literal:
    """What holds between a phase and the next; its arguments are the action's, the robot's first."""
    names = dict.fromkeys((*op.spec.agents, *op.arguments))
    terms = (op.chosen.get(name, op.teams.get(name, (name,))[0]) for name in names)
    return Literal(under_way_predicate(op.spec.name, number), tuple(terms))


def _needed(op: Operator, intervals: Sequence[_Interval], index: int) -> Iterator[Literal]:
    spans = op.spans.get("preconditions", {})
    ends = {literal: _phase_at("delete", op, literal, intervals) for literal in op.deletes}
    for literal in op.preconditions:
        span = spans.get(literal, Span(START, END))
        if span == AT_START:
            is_needed = index == 0
        elif span == AT_END:
            is_needed = index == len(intervals) - 1
        else:
            begin, end = (moment.place for moment in intervals[index])
            first, last = (moment.place for moment in span.moments)
            is_needed = begin < last and end > first if begin != end else first <= begin <= last
        if is_needed and index <= ends.get(literal, index):
            yield literal


def _at(op: Operator, slot: str, intervals: Sequence[_Interval], index: int) -> Iterator[Literal]:
    literals = {
        "delete": op.deletes,
        "intended_effects": op.intended_effects,
        "other_effects": op.other_effects,
    }
    for literal in literals[slot]:
        if _phase_at(slot, op, literal, intervals) == index:
            yield literal


def _phase_at(slot: str, op: Operator, literal: Literal, intervals: Sequence[_Interval]) -> int:
    """The phase that changes a literal: the first that begins with a delete, the last that ends with an effect."""
    usual = START if slot == "delete" else END
    span = op.spans.get(slot, {}).get(literal)
    moment = usual if span is None else span.begin
    if slot == "delete":
        return next(n for n, (begin, _) in enumerate(intervals) if begin == moment)
    return max(n for n, (_, end) in enumerate(intervals) if end == moment)
