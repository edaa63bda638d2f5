"""A plain partial-order planner with causal links, as UCPOP is one (Penberthy & Weld 1992): the yardstick of its kind.

Best-first over partial plans by steps, open conditions and threats, which is UCPOP's default; threats are resolved
first, then the newest open condition. Our choice: actions are grounded beforehand, those alone whose conditions can
be reached at all if nothing is ever deleted, so that there are no variables to bind; that only helps it.
"""

import heapq
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

from unified_planning.engines.results import PlanGenerationResult, PlanGenerationResultStatus
from unified_planning.plans import ActionInstance, SequentialPlan

from benchmarks.domains.planners import PARTIAL_ORDER
from planner.fact import Fact
from planner.interchange.foreign import ReadProblem, read_up_problem
from planner.knowledge import GroundAction
from planner.plan_nets.precedence import members

START, END = 0, 1
CHECK_EVERY = 64
"""Partial plans between two looks at the clock."""

Link = tuple[int, Fact, int]


@dataclass(frozen=True, slots=True)
class PartialPlan:
    """Steps by number; `before[i]`: the bitset of those ordered before step i; open conditions, the newest last."""

    steps: tuple[GroundAction | None, ...]
    before: tuple[int, ...]
    links: frozenset[Link]
    open: tuple[tuple[Fact, int], ...]

    def ordered(self, one: int, other: int) -> "PartialPlan | None":
        """With one step before another; None if that is a circle."""
        if one == other or self.before[one] >> other & 1:
            return None
        if self.before[other] >> one & 1:
            return self
        earlier = self.before[one] | 1 << one
        before = tuple(
            mask | earlier if number == other or mask >> other & 1 else mask
            for number, mask in enumerate(self.before)
        )
        return PartialPlan(self.steps, before, self.links, self.open)


class PartialOrderPlanner:
    """Answers as an anytime planner of unified-planning does, with the first plan only."""

    skip_checks = True

    def get_solutions(self, problem: Any, timeout: float) -> Iterator[PlanGenerationResult]:
        deadline_s = time.monotonic() + timeout
        read = read_up_problem(problem)
        status = PlanGenerationResultStatus.TIMEOUT
        plan = None
        if (found := _search(read, deadline_s)) is not None:
            status = PlanGenerationResultStatus.SOLVED_SATISFICING
            plan = _up_plan(problem, read, found)
        yield PlanGenerationResult(status, plan, PARTIAL_ORDER)


def _search(read: ReadProblem, deadline_s: float) -> PartialPlan | None:
    """The first partial plan without flaws; None if time is over or none is left."""
    facts = read.problem.facts
    actions = reachable_actions(read)
    achievers: dict[Fact, list[GroundAction]] = {}
    for action in actions:
        for fact in action.effects:
            achievers.setdefault(fact, []).append(action)
    goals = tuple((goal, END) for goal in read.problem.goals)
    first = PartialPlan((None, None), (0, 1 << START), frozenset(), goals)
    number = count()
    queue = [(len(goals), next(number), first)]
    for looked_at in count():
        if not queue or (looked_at % CHECK_EVERY == 0 and time.monotonic() > deadline_s):
            return None
        _, _, plan = heapq.heappop(queue)
        threat = next(_threats(plan), None)
        if threat is None and not plan.open:
            return plan
        for better in _resolved(plan, threat) if threat else _closed(plan, facts, achievers):
            value = len(better.steps) + len(better.open) + sum(1 for _ in _threats(better))
            heapq.heappush(queue, (value, next(number), better))
    return None


def _threats(plan: PartialPlan) -> Iterator[tuple[Link, int]]:
    """The links with a step that deletes their fact and can come between."""
    for link in plan.links:
        producer, fact, consumer = link
        for number, step in enumerate(plan.steps):
            if step is None or number in (producer, consumer) or fact not in step.deletes:
                continue
            is_earlier = plan.before[producer] >> number & 1
            is_later = plan.before[number] >> consumer & 1
            if not is_earlier and not is_later:
                yield link, number


def _resolved(plan: PartialPlan, threat: tuple[Link, int]) -> Iterator[PartialPlan]:
    """Demotion and promotion."""
    (producer, _, consumer), number = threat
    for one, other in ((number, producer), (consumer, number)):
        if one != END and other != START and (better := plan.ordered(one, other)) is not None:
            yield better


def _closed(
    plan: PartialPlan, facts: frozenset[Fact], achievers: Mapping[Fact, Sequence[GroundAction]]
) -> Iterator[PartialPlan]:
    """With the newest open condition brought about by a step that there is, by the start, or by a new step."""
    fact, consumer = plan.open[-1]
    rest = plan.open[:-1]
    for number, step in enumerate(plan.steps):
        holds = fact in facts if number == START else step is not None and fact in step.effects
        if holds and (ordered := plan.ordered(number, consumer)) is not None:
            links = plan.links | {(number, fact, consumer)}
            yield PartialPlan(ordered.steps, ordered.before, links, rest)
    for action in achievers.get(fact, ()):
        new = len(plan.steps)
        before = [*plan.before, 1 << START]
        before[END] |= 1 << new
        wanted = (*rest, *((need, new) for need in action.preconditions))
        links = plan.links | {(new, fact, consumer)}
        grown = PartialPlan((*plan.steps, action), tuple(before), links, wanted)
        if (ordered := grown.ordered(new, consumer)) is not None:
            yield ordered


def reachable_actions(read: ReadProblem) -> list[GroundAction]:
    """The ground actions whose conditions can be reached if nothing is ever deleted."""
    base, problem = read.knowledge_base, read.problem
    known = set(problem.facts)
    found: dict[tuple[str, tuple[str, ...]], GroundAction] = {}
    fresh = True
    while fresh:
        fresh = False
        by_predicate: dict[str, list[tuple[str, ...]]] = {}
        for fact in known:
            by_predicate.setdefault(fact.predicate, []).append(fact.args)
        for operator in base.operators:
            bindings: list[dict[str, str]] = [{}]
            for need in sorted(operator.preconditions, key=lambda need: need.predicate in base.fluents):
                bindings = [
                    joined
                    for binding in bindings
                    for args in by_predicate.get(need.predicate, ())
                    if (joined := operator.extended(binding, need.terms, args)) is not None
                ]
            for binding in bindings:
                key = operator.name, tuple(binding[name] for name in operator.parameters)
                if key in found or base.misfit(operator, binding, problem.objects) is not None:
                    continue
                if (action := operator.ground(binding, problem.functions)) is not None:
                    found[key] = action
                    fresh = True
        for action in found.values():
            known.update(action.effects)
    lasting = [fact for fact in problem.facts if fact.predicate not in base.fluents]
    return [_without(action, frozenset(lasting)) for action in found.values()]


def _without(action: GroundAction, lasting: frozenset[Fact]) -> GroundAction:
    """The action without the conditions that always hold."""
    needs = tuple(fact for fact in action.preconditions if fact not in lasting)
    return replace(action, preconditions=needs)


def _up_plan(problem: Any, read: ReadProblem, plan: PartialPlan) -> SequentialPlan:
    """One of its orders: steps by how many come before them."""
    order = sorted(range(2, len(plan.steps)), key=lambda number: sum(1 for _ in members(plan.before[number])))
    objects = problem.environment.expression_manager.ObjectExp
    instances = []
    for step in (plan.steps[number] for number in order):
        assert step is not None
        origin = read.actions[step.tag]
        named = [read.objects[step.arguments[name]] for name in origin.up_parameters]
        instances.append(ActionInstance(origin.up_action, tuple(map(objects, named))))
    return SequentialPlan(instances, problem.environment)
