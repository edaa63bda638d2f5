"""The seam behind which every planning engine stands."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol

from planner.fact import Fact
from planner.plan_net import PlanNet


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanningProblem:
    """What is to be planned, in the knowledge base's vocabulary.

    `objects` maps each object to its type; `functions` gives the numbers durations are made of, e.g.
    ("distance_m", ("door_1", "interchange_1")) -> 3.2; absent means the two are not connected.
    """

    objects: Mapping[str, str]
    facts: frozenset[Fact]
    goals: tuple[Fact, ...]
    functions: Mapping[tuple[str, tuple[str, ...]], float] = field(default_factory=dict)


class PlanningStatus(StrEnum):
    SOLVED = "solved"
    UNSOLVABLE = "unsolvable"  # proven
    NOT_FOUND = "not_found"  # the search ended without a plan and without a proof
    TIMED_OUT = "timed_out"
    OUT_OF_MEMORY = "out_of_memory"
    FAILED = "failed"


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanningResult:
    """`plan_net` is set exactly when solved; `reason` says why not otherwise, in words an operator reads."""

    status: PlanningStatus
    engine: str
    planning_s: float
    plan_net: PlanNet | None = None
    reason: str = ""
    lower_bound_s: float | None = None


class PlanningEngine(Protocol):
    """Problem in, validated plan-net or a result that says why not."""

    name: str

    def plan(self, problem: PlanningProblem, *, time_limit_s: float) -> PlanningResult: ...
