"""The interface of planning engines: problem, request, result, observer."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol

from planner.fact import Fact
from planner.knowledge import Numbers
from planner.plan_nets.forecast import Spreads
from planner.plan_nets.plan_net import PlanNet, Senses
from planner.problem.preference import Preference, PreferenceChoice
from planner.problem.timer import Clock, Timer


@dataclass(frozen=True, slots=True, kw_only=True)
class Crossing:
    """What a way does to a zone for one agent at a time: both if it leads through."""

    zone: str
    enters: bool
    leaves: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Access:
    """What of doors, hatches and lifts is asked for by others.

    :param ways: from one place to another → the facts that hold while somebody is on that way.
    :param positions: the arguments of a position after the first, such as (in, interchange_1) → the facts that hold
        while something comes to be there or ceases to be.
    :param to_end: such a fact → what must hold for it to be ended: a hatch with a sample in it is not closed.
    :param restored: what a plan that ends it brings about again before it ends, if it can.
    """

    ways: Mapping[tuple[str, str], tuple[Fact, ...]] = field(default_factory=dict)
    positions: Mapping[tuple[str, ...], tuple[Fact, ...]] = field(default_factory=dict)
    to_end: Mapping[Fact, tuple[Fact, ...]] = field(default_factory=dict)
    restored: frozenset[Fact] = frozenset()

    @property
    def facts(self) -> frozenset[Fact]:
        """All that ways and positions ask for."""
        return frozenset(fact for asked in (*self.ways.values(), *self.positions.values()) for fact in asked)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanningProblem:
    """What is to be planned, in the knowledge base's vocabulary.

    `objects` maps each object to its type; `functions` gives the numbers durations are made of, e.g.
    ("distance_m", ("door_1", "interchange_1")) -> 3.2; absent means the two are not connected.
    `deadlines_s` says by when a goal is to be true, seconds from the plan's start (negative if that is over);
    `not_before_s` before when it is not to become true: the action that achieves it does not start earlier, so that it
    is not true earlier however quick the action is; what holds already is left so.
    `priorities` how much its lateness counts, higher is more urgent, 0 unless told. `stages` is the order among goals:
    those of a higher stage are pursued once those of the lower ones are achieved; 0 unless told. `after`: by goal, the
    goals before whose achievement it is not to become true (`planner.plan_nets.orders`). `numbers` are the
    numeric facts that the facts of compared quantities follow from; they explain why a goal has no plan. `crossings`:
    the zones for one agent at a time that the way from one place to another enters or leaves (`planner.problem.zones`).
    `senses`: what robots perceive, of those that do not perceive all that is sensed; it decides what keeps orderings.
    `access`: the states of doors, hatches and lifts that ways and places ask for (`planner.problem.access`).
    `recruits`: by goal, the robots that may be recruited for it, where not all may; others may still make way.
    `avoids`: by goal, the places that nothing done for it uses. The hierarchical engine keeps to both; plans of others
    that do not are refused. `spreads`: how far durations vary, for
    forecasts and `Objective.ON_TIME`; no other plan depends on them. `values`: the goals that may be left out, and what
    each is worth (> 0); then no plan for them misses a deadline (`planner.engines.oversubscription`). `preferences`:
    constraints that a plan may break at a cost (`planner.engines.preferences`); goals and deadlines come before them.
    """

    objects: Mapping[str, str]
    facts: frozenset[Fact]
    goals: tuple[Fact, ...]
    functions: Mapping[tuple[str, tuple[str, ...]], float] = field(default_factory=dict)
    deadlines_s: Mapping[Fact, float] = field(default_factory=dict)
    not_before_s: Mapping[Fact, float] = field(default_factory=dict)
    priorities: Mapping[Fact, int] = field(default_factory=dict)
    stages: Mapping[Fact, int] = field(default_factory=dict)
    after: Mapping[Fact, frozenset[Fact]] = field(default_factory=dict)
    numbers: Numbers = field(default_factory=dict)
    crossings: Mapping[tuple[str, str], tuple[Crossing, ...]] = field(default_factory=dict)
    senses: Senses = field(default_factory=dict)
    access: Access = field(default_factory=Access)
    recruits: Mapping[Fact, frozenset[str]] = field(default_factory=dict)
    avoids: Mapping[Fact, frozenset[str]] = field(default_factory=dict)
    spreads: Spreads = field(default_factory=dict)
    values: Mapping[Fact, float] = field(default_factory=dict)
    preferences: tuple[Preference, ...] = ()

    @property
    def zones(self) -> frozenset[str]:
        """The zones for one agent at a time."""
        return frozenset(one.zone for crossed in self.crossings.values() for one in crossed)


class Objective(StrEnum):
    """Quantity to minimise; the others break ties."""

    MAKESPAN = "makespan"  # seconds from the plan's start to its last end
    ROBOTS = "robots"  # number of robots used
    ENERGY = "energy"  # joules of all robots together
    ON_TIME = (
        "on_time"  # goals that miss their deadlines, expected number by priority (`planner.engines.on_time`)
    )


KEPT_S = 5.0
"""Seconds of makespan that a kept action is worth. Our choice: about the time to release a sample; an operator who has
seen a plan should see few changes to it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanningRequest:
    """How a problem is to be solved.

    :param time_limit_s: an engine answers by then, with the best plan it has.
    :param effort_s: time to improve the first plan; None leaves it to the engine, by the problem's size.
    :param seed: same problem, request and machine-independent effort (`effort_s` None): same plan-net.
    :param like: a plan-net to keep to where that pays: each of its actions that another plan does not have counts as
        `KEPT_S` seconds of makespan. The hierarchical engine begins with it; others do not know it.
    :param resumes: what is left of a plan under way is planned: things may lie where they are only passed on. Another
        hint that the hierarchical engine uses.
    :param clock: what limits are measured by.
    """

    time_limit_s: float = 60.0
    effort_s: float | None = None
    objective: Objective = Objective.MAKESPAN
    memory_limit_mb: int = 2048
    seed: int = 0
    like: PlanNet | None = None
    resumes: bool = False
    clock: Clock = time.monotonic

    def timer(self) -> Timer:
        """Begins to measure the time limit."""
        return Timer(self.time_limit_s, self.clock)


class PlanningStatus(StrEnum):
    """How planning ended."""

    SOLVED = "solved"  # there is a validated plan-net
    UNSOLVABLE = "unsolvable"  # proven
    NOT_FOUND = "not_found"  # the search ended without a plan and without a proof
    TIMED_OUT = "timed_out"  # the time limit was reached without a plan
    OUT_OF_MEMORY = "out_of_memory"  # the memory limit was reached without a plan
    FAILED = "failed"  # the problem is not of the knowledge base, or the engine has a defect


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """An optional goal that the plan does not achieve, what it is worth, and why not, in words."""

    goal: Fact
    value: float
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanningResult:
    """`plan_net` is set exactly when solved; `reason` says why not otherwise, in words an operator reads.

    `lower_bound_s` is a proven lower bound of the makespan: no plan is shorter. Of optional goals: `value` is what the
    achieved ones are worth together, `value_bound` what no choice that was not looked at exceeds; None without any.
    `preferences`: which of them the plan keeps, the bound being that of plans that keep the same; None without any.
    """

    status: PlanningStatus
    engine: str
    planning_s: float
    plan_net: PlanNet | None = None
    reason: str = ""
    lower_bound_s: float | None = None
    value: float | None = None
    value_bound: float | None = None
    left_out: tuple[LeftOut, ...] = ()
    preferences: PreferenceChoice | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """An engine's progress: the makespan of its best plan and its lower bound so far."""

    engine: str
    elapsed_s: float
    makespan_s: float | None = None
    lower_bound_s: float | None = None


class Observer:
    """Receives an engine's progress and says whether it should stop and answer with its best plan."""

    def progress(self, progress: Progress) -> None:
        """Called now and then while the engine runs."""

    def should_stop(self) -> bool:
        """True: end soon and answer with the best plan so far."""
        return False


UNOBSERVED = Observer()


class PlanningEngine(Protocol):
    """Problem in, validated plan-net or a result that says why not."""

    name: str

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult: ...


def warm_up(engine: PlanningEngine) -> None:
    """Let an engine load and compile what it needs, if it can, so that no request pays for it."""
    warm: Callable[[], None] | None = getattr(engine, "warm_up", None)
    if warm is not None:
        warm()
