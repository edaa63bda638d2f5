"""Composes fragments into one sequence of ground actions by scheduling, with agents recruited."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from planner.engines.hierarchical.legs.leg import ClassifiedProblem
from planner.engines.hierarchical.legs.stops import MAX_NEAR_STOPPING, Sequenced
from planner.engines.hierarchical.scheduling.annealing import Annealing, Schedule
from planner.engines.hierarchical.scheduling.construction import Constructor
from planner.engines.hierarchical.scheduling.decoder_state import NONE
from planner.engines.hierarchical.scheduling.model import NEAR, PUSH, STRICT, Choice, Floats, Model, ints
from planner.engines.hierarchical.scheduling_problem import Move, SchedulingProblemBuilder, Task
from planner.knowledge import GroundAction
from planner.plan_nets.plan_net import PlanNet
from planner.problem.interface import PlanningRequest
from planner.problem.timer import Timer

MAX_EFFORT_S = 4.0
UNLIMITED_TRIALS = 10**9
"""Trials if the request sets the time."""
TRIALS = 40
TRIALS_A_LEG = 3
MAX_LEGS_DECODED = 3_500_000
MAX_TRIALS_INTERACTING = 40_000


def effort(request: PlanningRequest, legs: int, choices: int) -> tuple[int, float]:
    """The schedules to try, and the seconds after which to stop in any case.

    :param legs: of a schedule.
    :param choices: fragments to choose from where tasks interact, else 0.
    """
    if request.effort_s is not None:
        return UNLIMITED_TRIALS, request.effort_s
    if choices:
        return min(MAX_TRIALS_INTERACTING, TRIALS * legs * max(legs, choices)), MAX_EFFORT_S
    # As the square of the number of legs, as the cube if many, up to a maximum of legs decoded.
    trials = legs**2 * max(TRIALS, TRIALS_A_LEG * legs)
    return min(trials, MAX_LEGS_DECODED // max(1, legs)), MAX_EFFORT_S


CONSTRUCTED_CHOICES = 8
ORDERED_CHOICES = 8
"""Initial choices: constructed ones, then other orders."""
MANY_TASKS = 48
"""With more tasks, two other orders."""
CONSTRUCTED_LATER = 100
"""Choices that are constructed if schedules are to be improved."""
IN_VAIN = 4
"""No more are constructed then once so many in a row cannot be scheduled."""
RANDOM_CHOICES = 1000
"""Random choices, tried if no initial choice can be scheduled."""
MAX_WIDENINGS = 64
"""Maximum number of times the model is extended because an agent must make way."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Composed:
    """A sequence that reaches every task's goals, and its makespan in seconds."""

    makespan_s: float
    ground: Callable[[], tuple[GroundAction, ...]]
    """Makes the sequence; of many schedules that were found, few are asked for theirs."""

    @cached_property
    def actions(self) -> tuple[GroundAction, ...]:
        return self.ground()


class Composition:
    """The schedule of some tasks, improved by `improve`."""

    def __init__(
        self,
        classified: ClassifiedProblem,
        tasks: Sequence[Task],
        weights: Floats,
        request: PlanningRequest,
        moves: Sequence[Move] = (),
        is_over: Callable[[], bool] = lambda: False,
    ) -> None:
        """:param request: its `like` is what the first schedule is made of, if it can be.
        :param moves: an order in which the tasks can be carried out, if one is known.
        :raises OutOfTime: if `is_over()` before every way between the tasks is known.
        """
        self._moves = moves
        self._builder = SchedulingProblemBuilder(classified, tasks, is_over)
        self._weights = weights
        self._seed = request.seed
        self._like = request.like
        self._clock = request.clock
        self._model = self._builder.model()
        self._choice = Choice.of(ints([]), ints([]))
        self._random = np.random.default_rng(self._seed)
        """For constructed choices."""
        self._found: list[Schedule] = []
        """Each better than those before it."""
        self.trials = 0
        """Schedules tried to improve the first ones."""

    @property
    def legs(self) -> int:
        """Legs in a schedule, counting each task's longest alternative."""
        model = self._model
        return int(model.task_deadline_s.shape[0] * model.max_legs)

    @property
    def best_s(self) -> float:
        """The makespan of the best so far."""
        return self._found[-1].makespan_s

    @property
    def composed(self) -> Composed | None:
        """The best so far, None if the fragments do not compose."""
        return next(self.found(), None)

    def found(self) -> Iterator[Composed]:
        """What was found so far, the best first."""
        for schedule in reversed(self._found):
            ground = partial(self._builder.actions, schedule.steps, schedule.team)
            yield Composed(makespan_s=schedule.makespan_s, ground=ground)

    def begin(self) -> bool:
        """Find a first schedule; False if no initial choice can be scheduled."""
        if self._constructs:
            constructor = self._constructor()
            for _ in range(CONSTRUCTED_CHOICES):
                choice = constructor.choice(self._random)
                self._keep_with_stops(Schedule(self._model, choice, self._weights))
        for choice in self._ordered() if self._moves else self._first_choices():
            self._keep_with_stops(self._decoded(choice))
        for choice in self._at_random(0 if self._found else RANDOM_CHOICES):
            self._keep(Schedule(self._model, choice, self._weights))
        if self._found:
            self._choice = self._found[-1].choice
        return bool(self._found)

    def construct(self, seconds: float, go_on: Callable[[float], bool]) -> None:
        """Look for a better first schedule until the seconds are used up or `go_on(best makespan)` is False."""
        if not self._constructs or not self._found:
            return
        timer = Timer(seconds, self._clock)
        constructor = self._constructor()
        in_vain = 0
        for _ in range(CONSTRUCTED_LATER):
            if in_vain == IN_VAIN or timer.is_over or not go_on(self._found[-1].makespan_s):
                break
            schedule = Schedule(self._model, constructor.choice(self._random), self._weights)
            self._keep(schedule)
            in_vain = 0 if schedule.is_possible else in_vain + 1
        self._choice = self._found[-1].choice

    @property
    def _constructs(self) -> bool:
        """False if the order to begin with is known."""
        return not self._moves and self._like is None

    def _constructor(self) -> Constructor:
        return Constructor(self._model, self._comes_last())

    def _comes_last(self) -> list[bool]:
        """Of each task, whether it is carried out after the others."""
        return [*map(self._builder.is_final_configuration, range(len(self._model.task_deadline_s)))]

    def _at_random(self, count: int) -> Iterator[Choice]:
        """Random orders and alternatives: things that come from both sides block each other in most orders."""
        random = np.random.default_rng(self._seed)
        model = self._model
        legs = np.arange(model.task_deadline_s.shape[0] * model.max_legs, dtype=np.int32)
        for _ in range(count):
            order = random.permutation(legs).astype(np.int32)
            yield Choice.of(order, self._varied(random, model))

    def _keep_with_stops(self, schedule: Schedule) -> None:
        """Keep the schedule, or the same with all agents stopping on their ways, if it is the best so far."""
        self._keep(schedule)
        if schedule.is_possible:
            for stops in (NEAR, NEAR | PUSH, PUSH):
                stepping = schedule.settled._replace(stops=np.full_like(schedule.choice.stops, stops))
                self._keep(Schedule(self._model, stepping, self._weights))

    def _keep(self, schedule: Schedule) -> None:
        if schedule.is_possible and (not self._found or schedule.merit < self._found[-1].merit):
            self._found.append(schedule)

    def vary(self, fragments: Sequence[Sequence[Sequenced]]) -> None:
        """Offer each task more fragments, and agents stops near to where several legs end."""
        legs = self._model.max_legs
        self._builder.vary(fragments)
        if len(fragments) <= MAX_NEAR_STOPPING:
            self._builder.stop_near()
        self._model = self._builder.model()
        self._choice = _with_places(self._choice, legs, self._model.max_legs)

    def improve(self, trials: int, seconds: float, go_on: Callable[[float], bool]) -> None:
        """Anneal until the trials or the seconds are used up or `go_on(best makespan in seconds)` is False.

        The clock only decides where the search ends: the longer, the better, never worse.
        """
        if not self._found:
            return
        timer = Timer(seconds, self._clock)
        if seconds <= 0.0 or not go_on(self._found[-1].makespan_s):
            return
        search = Annealing(self._model, self.start(), self._weights, seed=self._seed)
        while search.trials < trials and not timer.is_over:
            if search.go_on(trials - search.trials):
                self._choice = search.best
                self._keep(Schedule(self._model, search.best, self._weights))
            self.trials = min(trials, search.trials)
            if not go_on(self._found[-1].makespan_s):
                break

    def start(self) -> Schedule:
        """The best so far in the present model, with its agents settled unless that is worse."""
        schedule = self._decoded(self._choice)
        settled = Schedule(self._model, schedule.settled, self._weights)
        return min(settled, schedule, key=lambda one: one.merit)

    def _decoded(self, choice: Choice) -> Schedule:
        """The choice's schedule; the model is widened where an agent has to make way for it."""
        schedule = Schedule(self._model, choice, self._weights)
        for _ in range(MAX_WIDENINGS):
            if schedule.is_possible or schedule.missing < 0:
                break
            if not self._builder.leave(schedule.configurations, self._builder.facts[schedule.missing]):
                break
            self._model = self._builder.model()
            schedule = Schedule(self._model, choice, self._weights)
        return schedule

    def _ordered(self) -> Iterator[Choice]:
        """The moves one after the other; nothing if one of them is of no fragment, or a leg is in two."""
        model = self._model
        tasks = model.task_deadline_s.shape[0]
        alternative = np.zeros(tasks, np.int32)
        order: list[int] = []
        for move in self._moves:
            found = self._builder.legs_in(move)
            if found is None:
                return
            alternative[move.task], legs = found
            order += [move.task * model.max_legs + leg for leg in legs]
        if len(set(order)) < len(order):
            return
        rest = np.setdiff1d(np.arange(tasks * model.max_legs), order)
        choice = Choice.of(np.concatenate([order, rest]).astype(np.int32), alternative)
        yield from _in_this_order(choice)

    def _first_choices(self) -> Iterator[Choice]:
        """What the plan-net to keep to does; the usual ones if there is none or it cannot be scheduled."""
        if self._like is not None:
            yield from _in_this_order(self._liked(self._like))
        if self._like is None or not self._found:
            yield from self._initial_choices()

    def _liked(self, like: PlanNet) -> Choice:
        """What the plan-net does, in its order, by the same agents; what it does not do comes last."""
        model = self._model
        tasks = model.task_deadline_s.shape[0]
        legs = tasks * model.max_legs
        alternative = np.zeros(tasks, np.int32)
        agent = np.full(legs, NONE, np.int32)
        starts_s = np.full(legs, np.inf)
        actions = sorted(like.actions, key=lambda action: action.earliest_start_s)
        for task in range(tasks):
            if (found := self._builder.legs_like(task, actions)) is None:
                continue
            alternative[task] = found.alternative
            for leg, start_s in found.starts_s.items():
                starts_s[task * model.max_legs + leg] = start_s
                agent[task * model.max_legs + leg] = found.agents[leg]
        order = np.argsort(starts_s, kind="stable").astype(np.int32)
        return Choice.of(order, alternative)._replace(agent=agent)

    def _initial_choices(self) -> Iterator[Choice]:
        """One task after the other, all first legs before all second ones, and at random."""
        model = self._model
        tasks = model.task_deadline_s.shape[0]
        legs = np.arange(tasks * model.max_legs, dtype=np.int32)
        alternative = np.zeros(tasks, np.int32)
        last = np.repeat(self._comes_last(), model.max_legs)
        random = np.random.default_rng(self._seed)
        keys = [legs, legs % model.max_legs * tasks + legs // model.max_legs]
        for number in range(ORDERED_CHOICES if tasks <= MANY_TASKS else 2):
            key = keys[number] if number < len(keys) else random.permutation(len(legs))
            order = legs[np.lexsort((key, last))].astype(np.int32)
            varied = alternative if number < len(keys) else self._varied(random, model)
            yield Choice.of(order, varied)

    @staticmethod
    def _varied(random: np.random.Generator, model: Model) -> np.ndarray[tuple[int], np.dtype[np.int32]]:
        counts = np.diff(model.task_first)
        return (random.random(len(counts)) * counts).astype(np.int32)


def _in_this_order(choice: Choice) -> Iterator[Choice]:
    """The choice, then the same with its order kept more strictly.

    A later leg that goes first may take up the room which an earlier one needs.
    """
    for stops in (0, PUSH, PUSH | STRICT):
        yield choice._replace(stops=np.full_like(choice.stops, stops))


def _with_places(choice: Choice, before: int, now: int) -> Choice:
    """The choice where alternatives may have `now` legs instead of `before`; the legs that are new come last."""
    order = choice.order // before * now + choice.order % before
    new = np.setdiff1d(np.arange(len(choice.alternative) * now), order)
    agent, stops = np.full(len(order) + len(new), -1, np.int32), np.zeros(len(order) + len(new), np.int32)
    places = np.arange(len(choice.order)) // before * now + np.arange(len(choice.order)) % before
    agent[places] = choice.agent
    stops[places] = choice.stops
    return Choice(np.concatenate([order, new]).astype(np.int32), choice.alternative, agent, stops)
