"""The decoder's working state: the timelines of agents and shared facts, and the steps placed so far.

A shared fact's row: whether it holds (1 or 0); in seconds the end of the step that brought it about, of the last one
that needs it and of the one that deleted it; the agent that deleted it; and the numbers of those three steps. An
agent's row: when it is free, and the number of its last step. A number of -1 stands for none.
"""

from typing import NamedTuple

import numpy as np

from planner.engines.hierarchical.scheduling.model import MAX_AGENTS, Floats, Ints, Model

HOLDS, SINCE, UNTIL, GONE, BY, SINCE_AT, UNTIL_AT, GONE_AT = range(8)
COLUMNS = 8
FREE, LAST = range(2)
NONE = -1


class DecoderState(NamedTuple):
    """Shapes as in `Model`; a step's number is its place in `steps`."""

    facts: Floats  # (F, 8)
    free: Floats  # (A, 2)
    configuration: Ints  # (A,)
    role_agent: Ints  # (roles,) who plays each role
    ends: Floats  # (T,) seconds
    log: Floats  # (max_touched_facts, 1 + 8) facts and their rows before, to take back a leg
    logged: Ints  # (1,) of them, those of the leg placed or tried last
    before: Floats  # (4, MAX_AGENTS) the team's times, steps, configurations and roles before the leg
    team: Ints  # (MAX_AGENTS,) of the leg being placed
    steps: Ints  # (max_steps,) in the order they were placed
    step_agents: Ints  # (max_steps, MAX_AGENTS) their agents
    cause: Ints  # (max_steps,) the number of the step that each had to wait for longest
    step_leg: Ints  # (max_steps,) task·K + leg of the leg it belongs to
    taken: Ints  # (T·K,) the agent that took each leg
    missing_fact: Ints  # (1,) the fact that could not be had, NONE where all went well
    waiting: Ints  # (3, T·K) by priority: legs not placed yet, their task·K + leg, facts they wait for


def decoder_state_for(model: Model) -> DecoderState:
    """Room for the longest schedule there can be."""
    agents = model.agent_class.shape[0]
    tasks = model.task_deadline_s.shape[0]
    places = tasks * model.max_legs
    return DecoderState(
        facts=np.zeros((model.fact_true.shape[0], 8)),
        free=np.zeros((agents, 2)),
        configuration=model.agent_start.copy(),
        role_agent=np.full(model.roles, NONE, np.int32),
        ends=np.zeros(tasks),
        log=np.empty((model.max_touched_facts, 9)),
        logged=np.zeros(1, np.int32),
        before=np.zeros((4, MAX_AGENTS)),
        team=np.zeros(MAX_AGENTS, np.int32),
        steps=np.empty(model.max_steps, np.int32),
        step_agents=np.zeros((model.max_steps, MAX_AGENTS), np.int32),
        cause=np.full(model.max_steps, NONE, np.int32),
        step_leg=np.full(model.max_steps, NONE, np.int32),
        taken=np.full(places, NONE, np.int32),
        missing_fact=np.full(1, NONE, np.int32),
        waiting=np.empty((3, places), np.int32),
    )
