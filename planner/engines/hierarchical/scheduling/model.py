"""The scheduling problem as arrays: what the decoder and the annealing work on.

Everything is numbered: agents, classes, configurations, needs, ways between them, legs, steps (ground actions with
their agents left open, or phases of such), and the *shared* facts, those fluent facts that are no agent's
configuration. Ranges are given as in compressed sparse rows: the items of i are `first[i] … first[i + 1] - 1`.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Ints = npt.NDArray[np.int32]
Floats = npt.NDArray[np.float64]

UNREACHABLE = -1
BACK = 1
NEAR = 2
AHEAD = 4
PUSH = 8
STRICT = 16
ITSELF = 0
"""A later step of its fragment needs what the step intends."""
GOES_ON = 1
"""Its agent does something later, or a later step needs one of its excuses."""
EXCUSED = 2
"""A later step needs one of its excuses (table 3: it makes way)."""
HEADER = 4
"""A step's data begin with: a mask (bit k set: the leg's k-th agent takes part), numbers of needs, deletes and adds."""
MAX_AGENTS = 4
"""Agents that may carry out one leg together."""


class Model(NamedTuple):
    """Shapes: A agents, K classes, C configurations, N needs, W ways, T tasks, M alternatives, L legs,
    S slots (an agent's part in a leg), P steps, F shared facts."""

    agent_class: Ints  # (A,)
    agent_start: Ints  # (A,) configuration
    member_first: Ints  # (K+1,) into members
    members: Ints  # agents by class
    task_first: Ints  # (T+1,) into alternatives
    task_deadline_s: Floats  # (T,) inf where there is none
    task_weight: Floats  # (T,) of lateness
    leg_first: Ints  # (M+1,) into legs
    slot_first: Ints  # (L+1,) into slots
    slot_class: Ints  # (S,)
    slot_need: Ints  # (S,)
    slot_effect: Ints  # (S,)
    slot_role: Ints  # (S,) within all roles
    slot_agent: Ints  # (S,) the agent it must be, -1 any of the class
    core_first: Ints  # (L+1,) into core_steps
    core_steps: Ints
    way: Ints  # (C, N) way from a configuration to a need, UNREACHABLE if none
    after: Ints  # (C, E) configuration after a leg's effect
    way_first: Ints  # (W+1,) into way_steps
    way_steps: Ints
    way_actions: Ints  # (W,) how many actions it is; those with phases are several steps
    way_end: Ints  # (W,) configuration
    way_span_s: Floats  # (W,)
    near_first: Ints  # (C+1,) into near_ways: the quickest single steps to where some leg begins, to make way
    near_ways: Ints
    leave_first: Ints  # (A+1,) into leave_from and leave_ways: an agent's single steps to make way
    leave_from: Ints  # configuration
    leave_ways: Ints
    step_span_s: Floats  # (P,)
    step_energy_j: Floats  # (P,)
    step_use: Ints  # (P,) what a step is there for: ITSELF, GOES_ON or EXCUSED
    excuse_first: Ints  # (P+1,) into excuses
    excuses: Ints  # shared facts that a step may be there for if a later one needs them
    step_at: (
        Ints  # (P,) where a step's data begin: HEADER numbers, then the shared facts it needs, deletes, adds
    )
    step_data: Ints
    fact_true: Ints  # (F,) 1 where it holds at first
    fact_by_setup: Ints  # (F,) 1 where some way brings it about
    hold_facts: Ints  # shared facts that an agent holds back at first by where it stands …
    hold_agents: Ints  # … and that agent
    ahead_first: (
        Ints  # (N+1,) into ahead_needs: for each need those from which it is met soonest, to wait there
    )
    ahead_needs: Ints
    goal_facts: Ints  # shared facts that must hold at the end
    final_agent: Ints  # agents that must end …
    final_need: Ints  # … in a configuration that has this need
    roles: int
    max_legs: int  # K, the most legs an alternative has
    max_steps: int  # a schedule cannot have more
    max_touched_facts: int  # shared facts touched by a leg and its setups


class Choice(NamedTuple):
    """A point of the search: which leg has priority, which alternative each task takes, which agent each leg.

    `order` (T·K,) holds task·K + leg, K the most legs an alternative has; `alternative` (T,); `agent` (T·K,) says who
    takes the leg, -1 whoever can begin first; `stops` (T·K,) says where that agent stops on its way there: 0 nowhere,
    BACK where it stood at first or NEAR, at the nearest place, and then perhaps (+ AHEAD) near to where the leg begins;
    + PUSH: who stands in the leg's way makes way at once, not only when nothing else goes on;
    + STRICT: no leg of lower priority is placed before it.
    """

    order: Ints
    alternative: Ints
    agent: Ints
    stops: Ints

    @classmethod
    def of(cls, order: Ints, alternative: Ints) -> "Choice":
        """The choice in which the agent that can begin first takes a leg, and no agent stops on its way."""
        return cls(order, alternative, np.full_like(order, -1), np.zeros_like(order))


def rows(lists: list[list[int]]) -> tuple[Ints, Ints]:
    """Lists as first indices and items."""
    first = np.zeros(len(lists) + 1, dtype=np.int32)
    first[1:] = np.cumsum([len(items) for items in lists]) if lists else []
    return first, ints([item for items in lists for item in items])


def ints(items: list[int]) -> Ints:
    return np.array(items, dtype=np.int32)


def floats(items: list[float]) -> Floats:
    return np.array(items, dtype=np.float64)
