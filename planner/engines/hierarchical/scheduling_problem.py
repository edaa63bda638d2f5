"""Converts tasks with fragments to the arrays of the scheduling problem, and schedules to ground actions."""

from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.engines.hierarchical.legs.leg import ClassifiedProblem, Leg, legs_of, renamed
from planner.engines.hierarchical.legs.travel import Travel
from planner.engines.hierarchical.scheduling.decoder_state import NONE
from planner.engines.hierarchical.scheduling.model import (
    EXCUSED,
    GOES_ON,
    ITSELF,
    UNREACHABLE,
    Ints,
    Model,
    floats,
    ints,
    rows,
)
from planner.fact import Fact
from planner.knowledge import GroundAction
from planner.plan_nets.difference import Activity, by_anyone
from planner.plan_nets.plan_net import PlanNetAction

NO_DEADLINE_S = 1e12


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """Goals that are reached together, and the sequences that reach them, quickest first."""

    goals: tuple[Fact, ...]
    fragments: tuple[tuple[GroundAction, ...], ...]
    deadline_s: float = NO_DEADLINE_S
    weight: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Move:
    """The actions `first` to `last` (exclusive) of one of a task's fragments, to be scheduled together."""

    task: int
    actions: tuple[GroundAction, ...]
    first: int
    last: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Likeness:
    """The number of an alternative that does what a plan-net does, and for its legs when that does it and who, by
    number; `NONE` if the agent is not of the leg's class."""

    alternative: int
    starts_s: Mapping[int, float]
    agents: Mapping[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Step:
    """A ground action or a phase of one with its agents left open, and the numbers of the shared facts it touches.

    `whole`: the action; of its phases, only the first has it.
    """

    action: GroundAction
    whole: GroundAction | None
    agents: tuple[str, ...]
    needs: list[int]
    deletes: list[int]
    adds: list[int]
    use: int
    excuses: list[int]

    @property
    def data(self) -> list[int]:
        """As `Model.step_data` has it."""
        mask = sum(1 << place for place, agent in enumerate(self.agents) if agent in self.action.agents)
        counts = [len(self.needs), len(self.deletes), len(self.adds)]
        return [mask, *counts, *self.needs, *self.deletes, *self.adds]


class SchedulingProblemBuilder:
    """Builds the model of one problem; `leave` extends it where an agent must make way."""

    def __init__(
        self,
        classified: ClassifiedProblem,
        tasks: Sequence[Task],
        is_over: Callable[[], bool] = lambda: False,
    ) -> None:
        """:param is_over: once True, `model` raises `OutOfTime` if ways between the tasks are still missing."""
        self._is_over = is_over
        self._problem = classified.problem
        self._classes = classes = classified.classes
        self._classified = classified
        self._tasks = list(tasks)
        self._travel = Travel(classified)
        base = classified.knowledge_base
        phased = base.phased_for(self._problem.facts)
        self._phased = {op.spec.name for op in base.operators if op.name in phased}
        """The actions that have phases by some agent."""
        self._agent_number = {agent: number for number, agent in enumerate(classes.agents)}
        self._facts: dict[Fact, int] = {}
        self._number_of: dict[Fact, int | None] = {}
        """By fact its number, None if it is not shared: the same few are looked up for each of many ways."""
        self._steps: list[_Step] = []
        self._slots: list[list[tuple[int, int, int, int, int]]] = []
        self._cores: list[list[int]] = []
        self._roles = 0
        self._most_phases = 1
        self._alternatives = [
            [self._add(fragment, task.goals) for fragment in task.fragments] for task in tasks
        ]
        self._postures = [
            (self._agent_number[agent], self._travel.need(agent, wanted))
            for agent in classes.agents
            if (wanted := classified.configuration(agent, self._problem.goals))
        ]
        self._way_steps: list[list[int]] = []
        self._first_steps: list[list[int]] = []

    def vary(self, fragments: Sequence[Sequence[tuple[GroundAction, ...]]]) -> None:
        """Add fragments to each task's alternatives; those it has already keep their numbers."""
        for task, some in enumerate(fragments):
            more = tuple(some)
            self._alternatives[task] += [self._add(fragment, self._tasks[task].goals) for fragment in more]
            self._tasks[task] = replace(self._tasks[task], fragments=(*self._tasks[task].fragments, *more))

    @property
    def facts(self) -> tuple[Fact, ...]:
        """The shared facts by number."""
        return tuple(self._facts)

    def is_final_configuration(self, task: int) -> bool:
        """True if the task is about where an agent ends."""
        return any(self._classified.is_configuration(goal) for goal in self._tasks[task].goals)

    def legs_in(self, move: Move) -> tuple[int, list[int]] | None:
        """The number of the move's fragment and of its legs; None if the task has no such fragment."""
        fragments = self._tasks[move.task].fragments
        if move.actions not in fragments:
            return None
        # Legs without a core are about where agents end: they belong to the last move.
        end = len(move.actions)
        last = end + 1 if move.last == end else move.last
        position = {id(action): at for at, action in reversed(list(enumerate(move.actions)))}
        legs = legs_of(move.actions, self._tasks[move.task].goals, self._classified)
        begins = [position[id(leg.core[0])] if leg.core else end for leg in legs]
        number = fragments.index(move.actions)
        return number, [leg for leg, at in enumerate(begins) if move.first <= at < last]

    def legs_like(self, task: int, actions: Sequence[PlanNetAction]) -> "Likeness | None":
        """The alternative of a task that does what these actions do, most of it by the same agents; None if none does.

        :param actions: in order of their starts.
        """
        found = [
            likeness
            for number, legs in enumerate(self._alternatives[task])
            if (likeness := self._likeness(number, legs, actions)) is not None
        ]
        return max(found, key=lambda one: sum(agent != NONE for agent in one.agents.values()), default=None)

    def _likeness(
        self, number: int, legs: Sequence[int], actions: Sequence[PlanNetAction]
    ) -> "Likeness | None":
        unused: dict[tuple[Activity, int], list[PlanNetAction]] = defaultdict(list)
        for action in actions:
            unused[by_anyone(action), action.phase].append(action)
        starts_s: dict[int, float] = {}
        agents: dict[int, int] = {}
        for place, leg in enumerate(legs):
            steps = [self._steps[step].action for step in self._cores[leg]]
            done = [some.pop(0) for step in steps if (some := unused[by_anyone(step), step.phase])]
            if len(done) < len(steps):
                return None
            if done:
                starts_s[place] = done[0].earliest_start_s
                kind = self._slots[leg][0][0]
                first = done[0].agents[0]
                is_same = self._classes.number(first) == kind
                agents[place] = self._agent_number[first] if is_same else NONE
        return Likeness(alternative=number, starts_s=starts_s, agents=agents)

    def leave(self, configurations: Ints, fact: Fact) -> bool:
        """Let agents in these configurations make way so that the fact comes about; True if that is new."""
        contended = frozenset(self._facts)
        pairs = zip(self._classes.agents, configurations.tolist(), strict=True)
        found = [self._travel.leave(agent, here, fact, contended) for agent, here in pairs]
        return any(found)

    def stop_near(self) -> None:
        """Let agents stop near to where several legs end."""
        self._travel.stop_near()

    def actions(self, steps: Ints, team: Ints) -> tuple[GroundAction, ...]:
        """The ground actions of decoded steps."""
        found = []
        for step, members in zip(steps.tolist(), team.tolist(), strict=True):
            if (whole := self._steps[step].whole) is not None:
                agents = zip(self._steps[step].agents, members, strict=False)
                found.append(renamed(whole, {old: self._classes.agents[new] for old, new in agents}))
        return tuple(found)

    def _add(self, actions: tuple[GroundAction, ...], goals: tuple[Fact, ...]) -> list[int]:
        """The legs of a fragment, by number."""
        legs = legs_of(actions, goals, self._classified)
        excused = self._excused(actions, goals)
        numbers = []
        played = Counter(role for leg in legs for role in leg.roles)
        for leg in legs:
            numbers.append(len(self._slots))
            self._slots.append([self._slot(leg, place) for place in range(len(leg.agents))])
            once = all(played[role] == 1 for role in leg.roles)
            inner = self._inner(leg) if once else frozenset()
            self._cores.append(
                [
                    step
                    for action in leg.core
                    for step in self._steps_of(action, leg.agents, excused.get(id(action)), inner)
                ]
            )
        self._roles += 1 + max((role for leg in legs for role in leg.roles), default=0)
        return numbers

    def _slot(self, leg: Leg, place: int) -> tuple[int, int, int, int, int]:
        agent = leg.agents[place]
        need = self._travel.need(agent, leg.needs[place])
        return (
            self._classes.number(agent),
            need,
            self._travel.effect(agent, leg.core, need),
            self._roles + leg.roles[place],
            self._agent_number[agent] if leg.bound[place] else -1,
        )

    def _excused(
        self, actions: Sequence[GroundAction], goals: Sequence[Fact]
    ) -> dict[int, tuple[int, list[Fact]]]:
        """By id the actions that intend nothing which is needed later, with what they bring about to make way."""
        found: dict[int, tuple[int, list[Fact]]] = {}
        needed = set(goals)
        predicates = self._classified.knowledge_base.predicates
        for action in reversed(actions):
            intended = action.intended_effects
            if needed.isdisjoint(intended) and not any(map(self._classified.is_configuration, intended)):
                ways = [fact for fact in action.effects if predicates[fact.predicate].make_way]
                found[id(action)] = EXCUSED, ways
            needed |= set(action.preconditions)
        return found

    def _inner(self, leg: Leg) -> frozenset[Fact]:
        """Facts about an agent that the leg itself brings about and needs: its own order of steps keeps them."""
        if any(leg.bound):
            return frozenset()
        made: set[Fact] = set()
        outer: set[Fact] = set()
        for action in leg.core:
            outer |= set(action.preconditions) - made
            made |= set(action.effects)
        return frozenset(fact for fact in made - outer if self._classified.agents_of(fact))

    def _steps_of(
        self,
        action: GroundAction,
        agents: tuple[str, ...],
        use: tuple[int, Sequence[Fact]] | None = None,
        inner: frozenset[Fact] = frozenset(),
    ) -> list[int]:
        """The action's phases by number, or itself if it has none.

        :param use: what the action is there for, with its excuses; None: for itself.
        """
        phases: Sequence[GroundAction] = (action,)
        if action.tag in self._phased:
            phases = self._classified.knowledge_base.phases_of(action, self._problem.facts)
        self._most_phases = max(self._most_phases, len(phases))
        # What all phases together bring about is of use after the last one.
        uses = [*[(ITSELF, ())] * (len(phases) - 1), use or (ITSELF, ())]
        return [
            self._step(phase, None if number else action, agents, uses[number], inner)
            for number, phase in enumerate(phases)
        ]

    def _step(
        self,
        action: GroundAction,
        whole: GroundAction | None,
        agents: tuple[str, ...],
        use: tuple[int, Sequence[Fact]],
        inner: frozenset[Fact],
    ) -> int:
        needs = self._shared([*action.preconditions, *self._awaited(action)], inner)
        adds = self._shared(action.effects, inner)
        # What passes through a zone has it to itself meanwhile.
        held = self._classified.knowledge_base.held
        zones = self._shared([fact for fact in action.deletes if fact.predicate in held])
        deletes = [fact for fact in self._shared(action.deletes, inner) if fact in zones or fact not in adds]
        self._steps.append(
            _Step(
                action=action,
                whole=whole,
                agents=agents,
                needs=needs,
                deletes=deletes,
                adds=adds,
                use=use[0],
                excuses=self._shared(use[1]),
            )
        )
        return len(self._steps) - 1

    def _awaited(self, action: GroundAction) -> list[Fact]:
        """The goals after which one that the action achieves is to come true: it is scheduled as if it needed them."""
        if not self._problem.after:
            return []
        goals = frozenset(self._problem.goals)
        return [
            before
            for goal in action.effects
            if goal in goals
            for before in sorted(self._problem.after.get(goal, frozenset()) & goals)
            if before not in action.effects
        ]

    def _shared(self, facts: Sequence[Fact], inner: frozenset[Fact] = frozenset()) -> list[int]:
        """The numbers of those that several agents may touch, each once."""
        found = []
        for fact in dict.fromkeys(facts):
            if fact in inner:
                continue
            if fact not in self._number_of:
                is_shared = (
                    self._classified.is_fluent(fact)
                    and fact.predicate not in self._classified.knowledge_base.under_way
                    and not self._classified.is_configuration(fact)
                )
                self._number_of[fact] = self._facts.setdefault(fact, len(self._facts)) if is_shared else None
            if (number := self._number_of[fact]) is not None:
                found.append(number)
        return found

    def model(self) -> Model:
        """The arrays, with every way that any schedule can need."""
        travel = self._travel
        classes = self._classes
        steps = self._steps
        travel.close(self._is_over)
        for way in travel.ways[len(self._way_steps) :]:
            of_actions = [
                self._steps_of(action, action.agents, (GOES_ON, action.effects)) for action in way.actions
            ]
            self._way_steps.append([step for steps_of in of_actions for step in steps_of])
            self._first_steps.append(of_actions[0] if of_actions else [])
        goal_facts = self._shared(self._problem.goals)
        way_step_first, way_steps = rows(self._way_steps)
        task_first, _ = rows([[0] * len(alternatives) for alternatives in self._alternatives])
        by_alternative = [legs for alternatives in self._alternatives for legs in alternatives]
        leg_first, _ = rows(by_alternative)
        # Legs are numbered by their alternatives: `vary` adds alternatives of tasks that are not the last.
        in_order = [leg for legs in by_alternative for leg in legs]
        slots_of = [self._slots[leg] for leg in in_order]
        slot_first, _ = rows([[0] * len(slots) for slots in slots_of])
        core_first, core_steps = rows([self._cores[leg] for leg in in_order])
        member_first, members = rows(
            [[self._agent_number[a] for a in names] for _, names in sorted(classes.members.items())]
        )
        step_at, step_data = rows([step.data for step in steps])
        excuse_first, excuses = rows([step.excuses for step in steps])
        near_first, near_ways = rows(travel.nearest())
        ahead_first, ahead_needs = rows(travel.ahead())
        leaves = [travel.leaves[agent] for agent in classes.agents]
        leave_first, leave_from = rows([[here for here, _ in ways] for ways in leaves])
        slots = np.array([s for group in slots_of for s in group], dtype=np.int32).reshape(-1, 5)
        by_setup = np.zeros(len(self._facts), np.int32)
        for group in self._way_steps:
            for step in group:
                by_setup[steps[step].adds] = 1
        holds = self._holds()
        return Model(
            agent_class=ints([classes.number(agent) for agent in classes.agents]),
            agent_start=ints([travel.starts[agent] for agent in classes.agents]),
            member_first=member_first,
            members=members,
            task_first=task_first,
            task_deadline_s=floats([task.deadline_s for task in self._tasks]),
            task_weight=floats([task.weight for task in self._tasks]),
            leg_first=leg_first,
            slot_first=slot_first,
            slot_class=np.ascontiguousarray(slots[:, 0]),
            slot_need=np.ascontiguousarray(slots[:, 1]),
            slot_effect=np.ascontiguousarray(slots[:, 2]),
            slot_role=np.ascontiguousarray(slots[:, 3]),
            slot_agent=np.ascontiguousarray(slots[:, 4]),
            core_first=core_first,
            core_steps=core_steps,
            way=_table(travel.way, len(travel.configurations), len(travel.needs)),
            after=_table(travel.after, len(travel.configurations), len(travel.effects)),
            way_first=way_step_first,
            way_steps=way_steps,
            way_actions=ints([len(way.actions) for way in travel.ways]),
            way_end=ints(travel.ends),
            way_span_s=floats([sum(a.duration_s for a in way.actions) for way in travel.ways]),
            near_first=near_first,
            near_ways=near_ways,
            leave_first=leave_first,
            leave_from=leave_from,
            leave_ways=ints([way for ways in leaves for _, way in ways]),
            step_span_s=floats([step.action.duration_s for step in steps]),
            step_energy_j=floats([step.action.energy_j for step in steps]),
            step_use=ints([step.use for step in steps]),
            excuse_first=excuse_first,
            excuses=excuses,
            step_at=step_at[:-1],
            step_data=step_data,
            fact_true=ints([int(fact in self._problem.facts) for fact in self._facts]),
            fact_by_setup=by_setup,
            hold_facts=ints([fact for fact, _ in holds]),
            hold_agents=ints([agent for _, agent in holds]),
            ahead_first=ahead_first,
            ahead_needs=ahead_needs,
            goal_facts=ints(goal_facts),
            final_agent=ints([agent for agent, _ in self._postures]),
            final_need=ints([need for _, need in self._postures]),
            roles=max(1, self._roles),
            max_legs=max((len(legs) for legs in by_alternative), default=1),
            max_steps=self._max_steps(),
            max_touched_facts=self._max_touched_facts(),
        )

    def _holds(self) -> list[tuple[int, int]]:
        """Facts that do not hold at first and that an agent's first step away would bring about, with the agent."""
        travel = self._travel
        found: dict[int, int] = {}
        for (here, _), way in travel.way.items():
            for agent, start in travel.starts.items():
                if start == here:
                    for fact in (fact for step in self._first_steps[way] for fact in self._steps[step].adds):
                        found.setdefault(fact, self._agent_number[agent])
        return sorted(found.items())

    def _max_steps(self) -> int:
        """Every task's longest alternative with the longest way for each slot, and everyone making way twice."""
        longest = max((len(way) for way in self._way_steps), default=0)
        legs = [
            max(
                sum(len(self._cores[leg]) + longest * len(self._slots[leg]) for leg in legs)
                for legs in alternatives
            )
            for alternatives in self._alternatives
        ]
        count = sum(len(max(alternatives, key=len)) for alternatives in self._alternatives)
        return 1 + sum(legs) + self._most_phases * (4 * count + 2 * len(self._classes.agents))

    def _max_touched_facts(self) -> int:
        touches = [len(step.needs) + len(step.deletes) + len(step.adds) for step in self._steps]
        most_way = max((sum(touches[s] for s in way) for way in self._way_steps), default=0)
        cores = [
            sum(touches[s] for s in core) + most_way * len(slots)
            for core, slots in zip(self._cores, self._slots, strict=True)
        ]
        return 1 + max([most_way, *cores]) + 2 * most_way


def _table(entries: Mapping[tuple[int, int], int], height: int, width: int) -> Ints:
    table = np.full((height, max(1, width)), UNREACHABLE, np.int32)
    for (row, column), value in entries.items():
        table[row, column] = value
    return table
