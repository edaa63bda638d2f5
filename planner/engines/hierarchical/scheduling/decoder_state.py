"""What the decoder works on: the timelines of agents and shared facts, and the steps placed so far.

A shared fact's row: whether it holds (1 or 0); in seconds the end of the step that brought it about, of the last one
that needs it and of the one that deleted it; the agent that deleted it; and the numbers of those three steps. An
agent's row: when it is free, and the number of its last step. A number of -1 stands for none.
"""

from typing import NamedTuple

import numpy as np

from planner.engines.hierarchical.scheduling.model import MOST_AGENTS, Floats, Ints, Model

HOLDS, SINCE, UNTIL, GONE, BY, SINCE_AT, UNTIL_AT, GONE_AT = range(8)
COLUMNS = 8
FREE, LAST = range(2)
NONE = -1


class Board(NamedTuple):
    """Shapes as in `Model`; a step's number is its place in `steps`."""

    facts: Floats  # (F, 8)
    free: Floats  # (A, 2)
    configuration: Ints  # (A,)
    role_agent: Ints  # (roles,) who plays each role
    ends: Floats  # (T,) seconds
    log: Floats  # (most_touches, 1 + 8) facts and their rows before, to take back a leg
    before: Floats  # (3, MOST_AGENTS) the team's times, steps and configurations before the leg
    team: Ints  # (MOST_AGENTS,) of the leg being placed
    steps: Ints  # (most_steps,) in the order they were placed
    crews: Ints  # (most_steps, MOST_AGENTS) their agents
    cause: Ints  # (most_steps,) the number of the step that each had to wait for longest
    served: Ints  # (most_steps,) task·K + leg of the leg it belongs to
    taken: Ints  # (T·K,) the agent that took each leg
    stuck: Ints  # (1,) the fact that could not be had, NONE where all went well
    waiting: Ints  # (3, T·K) by priority: legs not placed yet, their task·K + leg, facts they wait for


def board_for(model: Model) -> Board:
    """Room for the longest schedule there can be."""
    agents = model.agent_class.shape[0]
    tasks = model.task_deadline_s.shape[0]
    places = tasks * model.widest
    return Board(
        facts=np.zeros((model.fact_true.shape[0], 8)),
        free=np.zeros((agents, 2)),
        configuration=model.agent_start.copy(),
        role_agent=np.full(model.roles, NONE, np.int32),
        ends=np.zeros(tasks),
        log=np.empty((model.most_touches, 9)),
        before=np.zeros((3, MOST_AGENTS)),
        team=np.zeros(MOST_AGENTS, np.int32),
        steps=np.empty(model.most_steps, np.int32),
        crews=np.zeros((model.most_steps, MOST_AGENTS), np.int32),
        cause=np.full(model.most_steps, NONE, np.int32),
        served=np.full(model.most_steps, NONE, np.int32),
        taken=np.full(places, NONE, np.int32),
        stuck=np.full(1, NONE, np.int32),
        waiting=np.empty((3, places), np.int32),
    )
