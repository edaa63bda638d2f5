"""Plans whose actions use up numbers that are to be kept, such as batteries (`planner.problem.number_courses`).

An engine plans as if there were no numbers. Where its plan leaves one outside of what is kept, actions that are there
for that number (`ActionSpec.until`: CHARGE) are put in: before an earlier action of the same robot, with the way there
and back planned by the engine, and lasting for as long as the rest of the plan needs. Beside that, the engine plans
without the robots concerned; the better plan is taken. To leave numbers out of account makes no plan longer, so
that the engine's lower bound and its proofs that there is no plan hold for the whole problem.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice

from planner.engines.peripherals import attend
from planner.engines.plan_net_completion import complete_plan_net, confirm, merit
from planner.engines.wrapping import FirstProgress, WrappingEngine
from planner.errors import InvalidPlan, KnowledgeBaseError
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase, Operator
from planner.knowledge.comparison import Comparison, Term
from planner.plan_nets.plan_net import PlanNet, PlanNetAction
from planner.plan_nets.progression import progressed
from planner.plan_nets.validation import linearisation, sequence_of
from planner.problem.interface import (
    UNOBSERVED,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
)
from planner.problem.number_courses import Course, Point, courses, why_outside
from planner.problem.solving import TimeLimitedEngine
from planner.problem.static_facts import StaticFacts
from planner.problem.zones import ground, ground_action, groundings

MARGIN = 0.02
"""How much more than is needed an action for a number brings about, as durations vary; a share of the number's range
(our choice)."""
MAX_ROUNDS = 40
"""How many such actions are put in or lengthened."""
MAX_PLACES = 6
"""How many positions of the sequence such an action is tried at."""
MAX_WITHOUT = 3
"""How many robots plans are tried without."""


_Ways = Callable[[str, Sequence[Fact], frozenset[Fact]], list[GroundAction] | None]
"""By robot, goals and the facts it begins with, its actions; None: there are none."""


class ReplenishingEngine(WrappingEngine):
    """An engine whose plans keep numbers within their limits. Implements `PlanningEngine`."""

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        """The engine's answer; if its plan uses up a number, the best that does not, or why there is none."""
        relay = FirstProgress(observer)
        planner = TimeLimitedEngine(self._engine, request, relay)
        answer = planner.plan(problem)
        if answer.plan_net is None:
            return answer
        replenishment = Replenishment(problem, self._base, planner)
        plan_net = replenishment.sized(answer.plan_net)
        if not any(_outside(plan_net, problem, self._base)):
            return replace(answer, plan_net=replenishment.with_levels(plan_net))
        relay.is_first = False
        supplied = replenishment.supplied(plan_net)
        found = [supplied] if isinstance(supplied, PlanNet) else []
        found += replenishment.without_some(plan_net, supplied)
        planning_s = round(planner.timer.elapsed_s, 4)
        if isinstance(supplied, Outside) and not found:
            return replace(
                answer,
                status=PlanningStatus.NOT_FOUND,
                plan_net=None,
                reason=supplied.why,
                planning_s=planning_s,
            )
        best = min(found, key=lambda one: (one.late_s, *merit(one, request.objective)))
        confirm(best, problem, self._base)
        return replace(answer, plan_net=best, planning_s=planning_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class Outside:
    """A number that is not kept.

    :param robots: those that it is about.
    :param why: in words.
    """

    robots: frozenset[str]
    why: str


class Replenishment:
    """Puts actions that are there for a number into plan-nets, and has them last as long as is needed."""

    def __init__(
        self,
        problem: PlanningProblem,
        knowledge_base: KnowledgeBase,
        planner: TimeLimitedEngine | None = None,
    ) -> None:
        """:param planner: for the ways there and back; None: only actions that the plan-net has are made to last."""
        self._problem = problem
        self._base = knowledge_base
        self._planner = planner
        self._statics = StaticFacts(knowledge_base, problem)

    def sized(self, plan_net: PlanNet) -> PlanNet:
        """The plan-net whose actions for a number that goals ask for last until it is at its limit.

        Of a number that is not known, as long as it may take.
        """
        for index, action in enumerate(plan_net.actions):
            if not self._base.actions[action.tag].until or action.level is not None or action.under_way:
                continue
            for term in self._base.changed_numbers(action, self._problem.functions):
                limit, rate = self._limit(action, term), self._rate(action, term)
                if limit is None or not rate:
                    continue
                seconds = (limit.number - self._value_before(index, term, plan_net, rate)) / rate
                own = replace(
                    action, duration_s=round(max(action.duration_s, seconds), 3), level=limit.number
                )
                made = self._exchanged(plan_net, action, own)
                return plan_net if made is None else self.sized(made)
        return plan_net

    def _value_before(self, index: int, term: Term, plan_net: PlanNet, rate: float) -> float:
        """The number at the start of an action; the worst that plans let it have if it is not known."""
        for course in courses(plan_net, self._problem, self._base):
            if course.term == term:
                return course.before(index)
        spec = self._base.quantities[term[0]]
        end = 0 if rate > 0 else 1
        known = [bound for bound in (spec.kept[end], spec.range[end]) if bound is not None]
        return known[0] if known else 0.0

    def supplied(self, plan_net: PlanNet) -> PlanNet | Outside:
        """The plan-net with such actions where numbers would leave their limits; or what remains outside of them.

        :raises InvalidPlan: if the plan-net is none of the problem.
        """
        plan_net = self._trimmed(plan_net)
        found = next(_outside(plan_net, self._problem, self._base), None)
        for _ in range(MAX_ROUNDS):
            if found is None:
                break
            options = (option(plan_net, *found) for option in (self._lengthened, self._inserted))
            better = next((one for one in options if one and self._is_better(one, found[0])), None)
            if better is None:
                break
            plan_net = better
            found = next(_outside(plan_net, self._problem, self._base), None)
        if found is None:
            return self.with_levels(plan_net)
        return Outside(
            robots=frozenset(self._statics.robots).intersection(found[0].term[1]),
            why=why_outside(*found, plan_net.actions, self._base),
        )

    def without_some(self, plan_net: PlanNet, supplied: PlanNet | Outside) -> Iterator[PlanNet]:
        """Plan-nets without the robot whose number cannot be kept, again and again while there is one; without all the
        robots whose numbers run out in this one, and without each of them.

        :param supplied: what became of the plan-net.
        """
        assert self._planner is not None
        agents = set(plan_net.robots)
        outside = _outside(plan_net, self._problem, self._base)
        short = sorted({arg for course, _ in outside for arg in course.term[1] if arg in agents})
        waiting = [frozenset({robot}) for robot in short[:MAX_WITHOUT]]
        if len(short) > 1:
            waiting.insert(0, frozenset(short))
        tries = len(waiting)
        if isinstance(supplied, Outside):
            waiting.insert(0, supplied.robots)
            tries += MAX_WITHOUT
        tried: set[frozenset[str]] = set()
        while waiting and len(tried) < tries:
            robots = waiting.pop(0)
            if robots in tried:
                continue
            tried.add(robots)
            other = self._planner.plan_if_time(self._statics.without(robots))
            if other is None:
                break
            # Completed again, as who else would qualify is told of the whole problem.
            whole = None if other.plan_net is None else self.completed(other.plan_net.actions)
            made = None if whole is None else self.supplied(self.sized(whole))
            if isinstance(made, PlanNet):
                yield made
            elif made is not None:
                waiting.insert(0, robots | made.robots)

    def _is_better(self, plan_net: PlanNet, course: Course) -> bool:
        """Whether the number of the course is less far outside of its limits in this plan-net, in all."""
        found = courses(plan_net, self._problem, self._base)
        return all(one.excess < course.excess for one in found if one.term == course.term)

    def with_levels(self, plan_net: PlanNet) -> PlanNet:
        """The plan-net whose actions for numbers say what these are at their ends."""
        actions = list(plan_net.actions)
        for course in courses(plan_net, self._problem, self._base):
            quantity, args = course.term
            for index in course.raised_by:
                level = self._level(index, actions[index], course)
                words = self._base.quantities[quantity].words(quantity, args, level)
                actions[index] = replace(
                    actions[index],
                    level=round(level, 4),
                    description=f"{actions[index].description}, until {words}",
                )
        return replace(plan_net, actions=tuple(actions))

    def _level(self, index: int, action: PlanNetAction, course: Course) -> float:
        """The number at the action's end; its limit, if the number is beyond that already."""
        value = course.after(index)
        limit = self._limit(action, course.term)
        if limit is None:
            return value
        return min(value, limit.number) if limit.sign == "<=" else max(value, limit.number)

    def _trimmed(self, plan_net: PlanNet) -> PlanNet:
        """The plan-net whose actions for a number last no longer than until it is at its limit."""
        for course in courses(plan_net, self._problem, self._base):
            for index in course.raised_by:
                action = plan_net.actions[index]
                limit, rate = self._limit(action, course.term), self._rate(action, course.term)
                if limit is None or not rate or action.under_way:
                    continue
                least_s = ground_action(action.tag, action.arguments, self._problem, self._base).duration_s
                seconds = round(max(least_s, (limit.number - course.before(index)) / rate), 3)
                if seconds < action.duration_s:
                    made = self._exchanged(plan_net, action, replace(action, duration_s=seconds))
                    return plan_net if made is None else self._trimmed(made)
        return plan_net

    def _lengthened(self, plan_net: PlanNet, course: Course, point: Point) -> PlanNet | None:
        """The plan-net whose last action for the number before the point lasts for what comes after it."""
        before = [index for index in course.raised_by if index < point.action]
        if not before:
            return None
        last = before[-1]
        after = min((index for index in course.raised_by if index > last), default=len(plan_net.actions))
        action = plan_net.actions[last]
        limit, rate = self._limit(action, course.term), self._rate(action, course.term)
        if limit is None or not rate or action.under_way:
            return None
        lacking = max(one.excess for one in course.points if last < one.action <= after)
        lacking += MARGIN * self._base.quantities[course.term[0]].span
        more_s = min(lacking / abs(rate), (limit.number - course.after(last)) / rate)
        if more_s <= 0:
            return None
        longer = replace(action, duration_s=round(action.duration_s + more_s, 3))
        return self._exchanged(plan_net, action, longer)

    def _inserted(self, plan_net: PlanNet, course: Course, point: Point) -> PlanNet | None:
        """The best plan-net with one more action for the number before the point."""
        if self._planner is None:
            return None
        sequence = sequence_of(plan_net)
        for ways in (self._direct, self._planned):
            found = list(islice(self._with_visits(sequence, course, point, ways), MAX_PLACES))
            if found:
                return min(found, key=lambda one: (one.late_s, *merit(one)))
        return None

    def _with_visits(
        self, sequence: Sequence[GroundAction], course: Course, point: Point, ways: _Ways
    ) -> Iterator[PlanNet]:
        """The plan-nets with one more action for the number, the latest first."""
        assert self._planner is not None
        for visit in self._visits(course.term):
            for place in self._places(sequence, visit.agents[0], point.action):
                for order, there in self._openings(sequence, place, visit):
                    if self._planner.is_over:
                        return
                    made = self._with_visit(order, there, visit, course.term, ways)
                    if made is not None:
                        yield made
                        break

    def _with_visit(
        self, sequence: Sequence[GroundAction], place: int, visit: GroundAction, term: Term, ways: _Ways
    ) -> PlanNet | None:
        """The plan-net in which the robot goes and does the action before that place in the sequence; None if there is
        none, or the number does not last until then."""
        robot = visit.agents[0]
        before = sequence[:place]
        here = progressed(self._problem.facts, before)
        fluents = self._base.fluents
        there = ways(robot, [one for one in visit.preconditions if one.predicate in fluents], here)
        if there is None:
            return None
        arrived = progressed(here, [*there, visit])
        for skipped in self._skippable(sequence, place, robot, there):
            rest = [one for index, one in enumerate(sequence[place:], place) if index not in skipped]
            wanted = (
                self._needed(robot, rest, arrived, here)
                if not skipped
                else [one for one in sequence[skipped[-1]].intended_effects if one.predicate in fluents]
            )
            back = ways(robot, wanted, arrived)
            if back is None:
                continue
            made = self.completed([*before, *there, visit, *back, *rest])
            if made is not None:
                course = next(one for one in courses(made, self._problem, self._base) if one.term == term)
                earlier = [one for one in before if one.level is not None and self._limit(one, term)]
                if any(one.action <= course.raised_by[len(earlier)] for one in course.outside()):
                    return None
                return self._lengthened(made, course, course.points[-1]) or made
        return None

    def _skippable(
        self, sequence: Sequence[GroundAction], place: int, robot: str, there: Sequence[GroundAction]
    ) -> Iterator[tuple[int, ...]]:
        """The robot's next action with its phases, if it is of the kind that brought it there; then nothing.

        A robot that drives on from the place need not drive back first.
        """
        mine = [index for index in range(place, len(sequence)) if robot in sequence[index].agents]
        if mine and there and sequence[mine[0]].tag == there[-1].tag:
            chain = [mine[0]]
            for index in mine[1:]:
                if sequence[index].follows is None:
                    break
                chain.append(index)
            yield tuple(chain)
        yield ()

    def _needed(
        self, robot: str, rest: Sequence[GroundAction], arrived: frozenset[Fact], here: frozenset[Fact]
    ) -> list[Fact]:
        """What the robot's next action needs that held before it went."""
        following = next((one for one in rest if robot in one.agents), None)
        if following is None:
            return []
        return [fact for fact in following.preconditions if fact in here and fact not in arrived]

    def _planned(
        self, robot: str, goals: Sequence[Fact], facts: frozenset[Fact]
    ) -> list[GroundAction] | None:
        """The robot's own actions by which it achieves the goals; None if there is no plan."""
        assert self._planner is not None
        if facts.issuperset(goals):
            return []
        others = [one for one in self._statics.robots if one != robot]
        small = replace(
            self._problem,
            facts=facts,
            goals=tuple(goals),
            deadlines_s={},
            not_before_s={},
            priorities={},
            stages={},
            after={},
            recruits={},
            avoids={},
            values={},
            preferences=(),
        )
        answer = self._planner.plan(StaticFacts(self._base, small).without(others))
        if answer.plan_net is None:
            return None
        return sequence_of(answer.plan_net)

    def _direct(self, robot: str, goals: Sequence[Fact], facts: frozenset[Fact]) -> list[GroundAction] | None:
        """The robot's shortest single action that intends all of the goals; None if there is none."""
        if facts.issuperset(goals):
            return []
        able = (
            action
            for op in self._base.operators
            if len(op.agents) == 1
            for binding in _bindings(op, goals, {op.agents[0]: robot}, facts)
            if self._base.misfit(op, binding, self._problem.objects) is None
            and (action := ground(op, binding, self._problem, self._base)) is not None
            and all(fact in facts or fact.predicate in self._base.accesses for fact in action.preconditions)
        )
        shortest = min(able, key=lambda action: action.duration_s, default=None)
        return None if shortest is None else [shortest]

    def _places(self, sequence: Sequence[GroundAction], robot: str, last: int) -> Iterator[int]:
        """Where the robot may go from, the latest first: before its own actions, not within one."""
        for place in range(last, -1, -1):
            action = sequence[place] if place < len(sequence) else None
            if place == last or (action is not None and robot in action.agents):
                following = next((one for one in sequence[place:] if robot in one.agents), None)
                if following is None or (following.follows is None and not following.under_way):
                    yield place

    def _openings(
        self, sequence: Sequence[GroundAction], place: int, visit: GroundAction
    ) -> Iterator[tuple[Sequence[GroundAction], int]]:
        """The sequence and the place; then those where it comes before what others do where the robot is to go, or
        after that, with what the robot does from the place on put off: a charger may be shared."""
        yield sequence, place
        robot = visit.agents[0]
        where = self._problem.objects.keys() & set(visit.arguments.values()) - {robot}
        theirs = [
            index
            for index, action in enumerate(sequence)
            if robot not in action.agents and not where.isdisjoint(action.arguments.values())
        ]
        own = max((index for index in range(place) if robot in sequence[index].agents), default=-1)
        for index in reversed(theirs):
            if own < index < place and sequence[index].follows is None:
                yield sequence, index
        for index in theirs:
            if index >= place:
                soon, later = self._put_off(sequence[place : index + 1], robot)
                if sequence[index] in later:
                    return
                yield [*sequence[:place], *soon, *later, *sequence[index + 1 :]], place + len(soon)

    def _put_off(
        self, actions: Sequence[GroundAction], robot: str
    ) -> tuple[list[GroundAction], list[GroundAction]]:
        """Of actions in order those that can do without the robot's, and the robot's with those that cannot."""
        soon: list[GroundAction] = []
        later: list[GroundAction] = []
        for action in actions:
            waits = robot in action.agents or any(self._are_ordered(one, action) for one in later)
            (later if waits else soon).append(action)
        return soon, later

    def _are_ordered(self, one: GroundAction, other: GroundAction) -> bool:
        """Whether either changes what the other needs or changes."""
        changed = [{*action.effects, *action.deletes} for action in (one, other)]
        touched = [
            {*action.preconditions, *changes} for action, changes in zip((one, other), changed, strict=True)
        ]
        return not (changed[0].isdisjoint(touched[1]) and changed[1].isdisjoint(touched[0]))

    def _visits(self, term: Term) -> Iterator[GroundAction]:
        """The actions that are there for the number, as short as they can be."""
        for op in self._base.operators:
            if op.until is None or op.until[0].quantity != term[0]:
                continue
            told = dict(zip(op.until[1], term[1], strict=True))
            for action in groundings(op, self._problem, self._base, told):
                if self._rate(action, term):
                    # It is lengthened, and its level corrected, once the plan-net has its times.
                    yield replace(action, level=self._problem.numbers[term])

    def _rate(self, action: GroundAction, term: Term) -> float:
        """By how much the action changes the number a second."""
        amount = self._base.changed_numbers(action, self._problem.functions).get(term, 0.0)
        return amount / action.duration_s if action.duration_s else 0.0

    def _limit(self, action: GroundAction, term: Term) -> Comparison | None:
        """How far the action, if it is there for the number, changes it at most; None if it is not."""
        aim = self._base.aim_of(action)
        return None if aim is None or aim[1] != term else aim[0]

    def _exchanged(self, plan_net: PlanNet, action: PlanNetAction, other: PlanNetAction) -> PlanNet | None:
        """The plan-net with another action in the place of one; None if it is none."""
        return self.completed([other if one is action else one for one in linearisation(plan_net)])

    def completed(self, sequence: Sequence[GroundAction]) -> PlanNet | None:
        """The plan-net of the sequence; None if it is none."""
        sequence = [one.unscheduled() if isinstance(one, PlanNetAction) else one for one in sequence]
        attended = attend(sequence, self._problem, self._base)
        try:
            made = complete_plan_net(
                attended.sequence, replace(self._problem, goals=attended.goals), self._base, self._statics
            )
        except (InvalidPlan, KnowledgeBaseError):
            return None
        return made if isinstance(made, PlanNet) else None


def _bindings(
    op: Operator, goals: Sequence[Fact], binding: Mapping[str, str], facts: Collection[Fact]
) -> Iterator[Mapping[str, str]]:
    """The bindings of an operator by which it intends all of the goals and its pre-conditions are facts.

    :param binding: of some of its parameters.
    """
    if goals:
        for literal in op.intended_effects:
            if literal.predicate == goals[0].predicate:
                extended = op.extended(binding, literal.terms, goals[0].args)
                if extended is not None:
                    yield from _bindings(op, goals[1:], extended, facts)
        return
    open_literals = [
        literal
        for literal in op.preconditions
        if any(term in op.parameters and term not in binding for term in literal.terms)
    ]
    if not open_literals:
        if len(binding) == len(op.parameters):
            yield binding
        return
    # The literal with the fewest open terms leaves the fewest choices.
    literal = min(open_literals, key=lambda one: sum(term not in binding for term in one.terms))
    for fact in facts:
        if fact.predicate == literal.predicate:
            extended = op.extended(binding, literal.terms, fact.args)
            if extended is not None:
                yield from _bindings(op, (), extended, facts)


def _outside(
    plan_net: PlanNet, problem: PlanningProblem, knowledge_base: KnowledgeBase
) -> Iterator[tuple[Course, Point]]:
    """Where numbers leave what is kept, those first that do so first."""
    found = [
        (point.at_s, course.term, course, point)
        for course in courses(plan_net, problem, knowledge_base)
        for point in course.outside()
    ]
    return iter([(course, point) for _, _, course, point in sorted(found, key=lambda one: one[:2])])
