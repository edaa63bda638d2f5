"""Plans with doors, hatches and lifts, for engines that need not know of any.

The engine plans as if each stood as it is wanted, without those that cannot be made to. Its sequence is then given
the peripherals' own actions: one before the first action that asks for another state, and at the end those that restore
what the plan is to leave as it was. Extraction makes them parallel with what does not depend on them: a door opens
while the robot approaches, and an opening is shared. To leave conditions out makes no plan longer, so that the engine's
lower bound and its proofs that there is no plan hold for the whole problem.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

from planner.engines.plan_net_completion import complete_plan_net, confirm
from planner.errors import InvalidPlan
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.knowledge.phrases import denial, enumeration
from planner.plan_nets.plan_net import PlanNet
from planner.plan_nets.progression import apply_action
from planner.plan_nets.validation import linearisation
from planner.problem.access import peripherals_of, with_access
from planner.problem.interface import (
    UNOBSERVED,
    Access,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    warm_up,
)
from planner.problem.static_facts import StaticFacts
from planner.problem.zones import ground


@dataclass(frozen=True, slots=True, kw_only=True)
class Attended:
    """A sequence with the peripherals' own actions, and the goals with what it restores."""

    sequence: tuple[GroundAction, ...]
    goals: tuple[Fact, ...]


class PeripheralEngine:
    """An engine whose plans have the actions of doors, hatches and lifts. Implements `PlanningEngine`."""

    def __init__(self, engine: PlanningEngine, knowledge_base: KnowledgeBase) -> None:
        self._engine = engine
        self._base = knowledge_base
        self.name = engine.name

    def warm_up(self) -> None:
        warm_up(self._engine)

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        """The engine's answer, with the peripherals' actions if there is a plan."""
        peripherals = peripherals_of(problem, self._base)
        if not peripherals:
            return self._engine.plan(problem, request, observer)
        barred = problem.access.facts - obtainable(problem, self._base)
        answer = self._engine.plan(_without(peripherals, barred, problem), request, observer)
        if answer.plan_net is None:
            words = [denial(self._base, fact) for fact in sorted(barred)]
            reason = "; ".join(filter(None, [enumeration(words), answer.reason]))
            return replace(answer, reason=reason)
        try:
            plan_net = self._completed(linearisation(answer.plan_net), problem)
        except InvalidPlan as error:
            return replace(answer, status=PlanningStatus.FAILED, plan_net=None, reason=str(error))
        if isinstance(plan_net, str):
            return replace(answer, status=PlanningStatus.NOT_FOUND, plan_net=None, reason=plan_net)
        return replace(answer, plan_net=plan_net)

    def _completed(self, sequence: Sequence[GroundAction], problem: PlanningProblem) -> PlanNet | str:
        names = GroundAction.__dataclass_fields__
        plain = [GroundAction(**{name: getattr(action, name) for name in names}) for action in sequence]
        attended = attend([with_access(action, problem, self._base) for action in plain], problem, self._base)
        whole = replace(problem, goals=attended.goals)
        statics = StaticFacts(self._base, whole)
        plan_net = complete_plan_net(attended.sequence, whole, self._base, statics)
        if isinstance(plan_net, PlanNet):
            confirm(plan_net, whole, self._base)
        return plan_net


def operations(problem: PlanningProblem, knowledge_base: KnowledgeBase) -> Iterator[GroundAction]:
    """Every action that a peripheral could carry out, quickest first."""
    names = peripherals_of(problem, knowledge_base)
    file = knowledge_base.file
    found = []
    for op in knowledge_base.operators_among(set(problem.objects.values())):
        choices = [
            [name for name, kind in sorted(problem.objects.items()) if file.is_a(kind, wanted)]
            for wanted in op.parameters.values()
        ]
        if not op.agents or not all(
            names.issuperset(choices[list(op.parameters).index(a)]) for a in op.agents
        ):
            continue
        for values in product(*choices):
            binding = dict(zip(op.parameters, values, strict=True))
            if knowledge_base.misfit(op, binding, problem.objects) is None:
                action = ground(op, binding, problem, knowledge_base)
                if action is not None:
                    found.append(action)
    return iter(sorted(found, key=lambda action: (action.duration_s, str(action))))


def obtainable(problem: PlanningProblem, knowledge_base: KnowledgeBase) -> frozenset[Fact]:
    """The facts about peripherals that hold or that they can bring about."""
    known = set(problem.facts)
    left = list(operations(problem, knowledge_base))
    soft = {fact for needed in problem.access.to_end.values() for fact in needed}
    while able := [one for one in left if known.issuperset(set(one.preconditions) - soft)]:
        known.update(fact for one in able for fact in one.effects)
        left = [one for one in left if one not in able]
    return frozenset(known)


def attend(
    sequence: Sequence[GroundAction], problem: PlanningProblem, knowledge_base: KnowledgeBase
) -> Attended:
    """The sequence with the peripherals' actions where they are needed; those that it has and that are not under way
    are put in again where they are needed.

    What cannot be brought about is left out, so that the sequence is then found faulty; what cannot be restored stays.
    """
    names = peripherals_of(problem, knowledge_base)
    if not names:
        return Attended(sequence=tuple(sequence), goals=tuple(problem.goals))
    able = list(operations(problem, knowledge_base))
    state = set(problem.facts)
    achieved = set(problem.facts)
    attended: list[GroundAction] = []

    def do(action: GroundAction) -> None:
        apply_action(action, state, achieved)
        attended.append(action)

    def bring_about(fact: Fact, spared: Collection[Fact] = ()) -> None:
        if (found := _bringing_about(fact, able, state)) is not None and not set(found.deletes) & set(spared):
            do(found)

    for action in sequence:
        if not action.under_way and names.issuperset(action.agents):
            continue
        for fact in action.preconditions:
            if fact not in state and fact.predicate in knowledge_base.accesses:
                bring_about(fact)
        do(action)
    for goal in problem.goals:
        if goal not in achieved and not names.isdisjoint(goal.args):
            bring_about(goal)
    ended = [fact for fact in sorted(problem.access.restored) if fact not in achieved]
    for fact in ended:
        bring_about(fact, problem.goals)
    restored = (fact for fact in ended if fact in achieved)
    return Attended(sequence=tuple(attended), goals=tuple(dict.fromkeys((*problem.goals, *restored))))


def _bringing_about(fact: Fact, able: Sequence[GroundAction], state: Collection[Fact]) -> GroundAction | None:
    """The quickest of the actions that can be carried out now and are meant for the fact."""
    return next(
        (
            one
            for one in able
            if fact in one.intended_effects and all(needed in state for needed in one.preconditions)
        ),
        None,
    )


def _without(names: Collection[str], barred: Collection[Fact], problem: PlanningProblem) -> PlanningProblem:
    """The problem without the peripherals, and without the ways and places that ask for what cannot be had."""
    closed = {way for way, asked in problem.access.ways.items() if not set(asked).isdisjoint(barred)}
    shut = {end for end, asked in problem.access.positions.items() if not set(asked).isdisjoint(barred)}
    rooms = {end[-1:] for end in shut}
    goals = tuple(goal for goal in problem.goals if set(names).isdisjoint(goal.args))

    def is_kept(fact: Fact) -> bool:
        if not set(names).isdisjoint(fact.args):
            return False
        return fact in goals or (fact.args[1:] not in shut and fact.args not in rooms)

    return replace(
        problem,
        objects={name: kind for name, kind in problem.objects.items() if name not in names},
        facts=frozenset(filter(is_kept, problem.facts)),
        goals=goals,
        functions={
            call: value
            for call, value in problem.functions.items()
            if call[1] not in closed and set(names).isdisjoint(call[1])
        },
        stages={goal: stage for goal, stage in problem.stages.items() if goal in goals},
        deadlines_s={goal: due_s for goal, due_s in problem.deadlines_s.items() if goal in goals},
        access=Access(),
    )
