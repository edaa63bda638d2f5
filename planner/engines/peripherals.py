"""Plans with doors, hatches and lifts, for engines that need not know of any.

The engine plans as if each stood as it is wanted, without those that cannot be made to. Its sequence is then given
the peripherals' own actions: one before the first action that asks for another state, and at the end those that restore
what the plan is to leave as it was. Extraction makes them parallel with what does not depend on them: a door opens
while the robot approaches, and an opening is shared. To leave conditions out makes no plan longer, so that the engine's
lower bound and its proofs that there is no plan hold for the whole problem.

What opening and riding takes counts where the makespan is minimised: plans without some ways through the doors and
lifts of the plan found so far are tried, and the best is kept. A plan with the peripherals' actions is no shorter than
without them, which bounds the search.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf

from planner.engines.plan_net_completion import complete_plan_net, confirm
from planner.engines.wrapping import FirstProgress, WrappingEngine
from planner.errors import InvalidPlan
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.knowledge.phrases import denial, enumeration
from planner.plan_nets.plan_net import PlanNet, PlanNetAction
from planner.plan_nets.progression import apply_action
from planner.plan_nets.validation import linearisation
from planner.problem.access import peripherals_of, with_access
from planner.problem.interface import (
    UNOBSERVED,
    Access,
    Objective,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.problem.solving import TimeLimitedEngine
from planner.problem.static_facts import StaticFacts
from planner.problem.zones import groundings

Way = tuple[str, str]
"""From a place to another."""
MAX_TRIALS = 16
"""How many problems without some ways are tried beside the whole one; with several goals, so many fewer."""
SHORT_M = 0.3
"""Ways through a door that are longer than the shortest by no more count as short, too."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Attended:
    """A sequence with the peripherals' own actions, and the goals with what it restores."""

    sequence: tuple[GroundAction, ...]
    goals: tuple[Fact, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Trial:
    """The engine's plan without some ways, without and with the peripherals' actions."""

    avoided: frozenset[Way]
    plain: PlanNet
    whole: PlanNet


class PeripheralEngine(WrappingEngine):
    """An engine whose plans have the actions of doors, hatches and lifts. Implements `PlanningEngine`."""

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        """The engine's answer, with the peripherals' actions if there is a plan."""
        peripherals = peripherals_of(problem, self._base)
        if not peripherals:
            return self._engine.plan(problem, request, observer)
        barred = problem.access.facts - obtainable(problem, self._base)
        relay = FirstProgress(observer)
        planner = TimeLimitedEngine(self._engine, request, relay)
        answer = planner.plan(_without(peripherals, barred, problem))
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
        if request.objective is Objective.MAKESPAN:
            relay.is_first = False
            first = _Trial(avoided=frozenset(), plain=answer.plan_net, whole=plan_net)
            plan_net = self._quickest(first, problem, barred, planner)
        return replace(answer, plan_net=plan_net, planning_s=round(planner.timer.elapsed_s, 4))

    def _quickest(
        self, first: "_Trial", problem: PlanningProblem, barred: Collection[Fact], planner: TimeLimitedEngine
    ) -> PlanNet:
        """The best of the plan and of those that avoid some of what its ways ask for, by lateness, then makespan.

        Of a door or lift that the ways of a plan ask for, those that begin away from it are avoided, so that robots
        approach while it opens, or the long ones, so that it closes early, or all.
        """
        peripherals = peripherals_of(problem, self._base)
        options = _options(problem)
        best = first.whole
        seen = {first.avoided}
        waiting = [first]
        while waiting:
            trial = min(waiting, key=lambda one: _cost(one.plain))
            waiting.remove(trial)
            if _cost(trial.plain) >= _cost(best):
                break
            passing = [one for one in trial.whole.actions if peripherals.isdisjoint(one.agents)]
            used = {fact.args[0] for action in passing for fact in action.preconditions if fact.args}
            for option in (option for name in sorted(used & options.keys()) for option in options[name]):
                avoided = trial.avoided | option
                if avoided in seen:
                    continue
                if len(seen) * len(problem.goals) > MAX_TRIALS:
                    return best
                seen.add(avoided)
                answer = planner.plan_if_time(_without(peripherals, barred, problem, avoided=avoided))
                if answer is None:
                    return best
                found = None if answer.plan_net is None else self._tried(answer.plan_net, problem)
                if answer.plan_net is not None and found is not None:
                    waiting.append(_Trial(avoided=avoided, plain=answer.plan_net, whole=found))
                    best = min(best, found, key=_cost)
        return best

    def _tried(self, plain: PlanNet, problem: PlanningProblem) -> PlanNet | None:
        try:
            plan_net = self._completed(linearisation(plain), problem)
        except InvalidPlan:
            return None
        return plan_net if isinstance(plan_net, PlanNet) else None

    def _completed(self, sequence: Sequence[PlanNetAction], problem: PlanningProblem) -> PlanNet | str:
        plain = [with_access(action.unscheduled(), problem, self._base) for action in sequence]
        attended = attend(plain, problem, self._base)
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
    found: list[GroundAction] = []
    for op in knowledge_base.operators_among(set(problem.objects.values())):
        kinds = [op.parameters[agent] for agent in op.agents]
        able = {
            name for name, kind in problem.objects.items() if any(file.is_a(kind, wanted) for wanted in kinds)
        }
        if op.agents and able <= names:
            found += groundings(op, problem, knowledge_base)
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


def _cost(plan_net: PlanNet) -> tuple[float, float]:
    """Seconds of lateness and of makespan."""
    return plan_net.late_s, plan_net.makespan_s


def _options(problem: PlanningProblem) -> dict[str, tuple[frozenset[Way], ...]]:
    """By door or lift, the ways that plans may avoid: those that begin away from it, all but the shortest, and all."""
    through: dict[Fact, list[Way]] = {}
    for way, asked in sorted(problem.access.ways.items()):
        for fact in asked:
            through.setdefault(fact, []).append(way)
    found: dict[str, list[set[Way]]] = {}
    for fact, ways in through.items():
        lengths_m = {way: problem.functions.get(("distance_m", way), inf) for way in ways}
        most_m = min(lengths_m.values()) + SHORT_M
        long = {way for way in ways if lengths_m[way] > most_m}
        beside = {place for way in ways if way not in long for place in way}
        away = {way for way in long if way[0] not in beside}
        options = found.setdefault(fact.args[0], [set(), set(), set()])
        for option, some in zip(options, (away, long, ways), strict=True):
            option.update(some)
    return {name: tuple(map(frozenset, options)) for name, options in found.items()}


def _without(
    names: Collection[str],
    barred: Collection[Fact],
    problem: PlanningProblem,
    *,
    avoided: frozenset[Way] = frozenset(),
) -> PlanningProblem:
    """The problem without the peripherals, without the ways and places that ask for what cannot be had, and without
    those that are avoided."""
    closed = {
        way for way, asked in problem.access.ways.items() if not set(asked).isdisjoint(barred)
    } | avoided
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
        not_before_s={goal: start_s for goal, start_s in problem.not_before_s.items() if goal in goals},
        access=Access(),
    )
