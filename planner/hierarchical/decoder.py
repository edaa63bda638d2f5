"""Serial schedule generation: from priorities to a schedule. Compiled (numba).

The legs are taken by priority; a leg that cannot be placed yet (a fact it needs does not hold after the legs placed so
far) waits until it does. Where no leg can be placed, an agent that stands in the way makes way.
"""

import numpy as np

from planner.hierarchical.compiled import inlined, kernel
from planner.hierarchical.model import MOST_AGENTS, UNREACHABLE
from planner.hierarchical.placing import ANYTHING, ANYWHERE, BY, HOLDS, leave, place_leg

IMPOSSIBLE = 1e18
"""The cost of a choice that cannot be scheduled."""


_leave = kernel(leave)


@kernel
def decode(  # type: ignore[no-untyped-def]
    model, order, alternative, agent, aside, weights, out_steps, out_team, stuck, configuration, taken
):
    """Schedule the choice.

    :param weights: (5,) of a second of makespan, a joule, an agent used, a second of weighted lateness, and a second of
        all tasks' ends together.
    :param out_steps: (…,) the steps in the order they were placed; `out_team` (…, MOST_AGENTS) their agents.
    :param stuck: (1,) set to the fact that could not be had where the cost is IMPOSSIBLE, else -1.
    :param taken: (T·K,) set to the agent that took each leg.
    :param configuration: (A,) set to the agents' configurations at the end.
    :returns: the cost, the number of steps placed, the makespan in seconds.
    """
    facts = np.zeros((model.fact_true.shape[0], 5))
    facts[:, HOLDS], facts[:, BY] = model.fact_true, ANYTHING
    for n in range(model.hold_facts.shape[0]):
        facts[model.hold_facts[n], BY] = model.hold_agents[n]
    free = np.zeros(model.agent_class.shape[0])
    configuration[:] = model.agent_start
    role_agent = np.full(model.roles, -1, np.int32)
    log = np.empty((model.most_touches, 6))
    team = np.zeros(MOST_AGENTS, np.int32)
    ends = np.zeros(alternative.shape[0])
    legs = np.empty(order.shape[0], np.int32)
    places = np.empty(order.shape[0], np.int32)
    waits_for = np.full(order.shape[0], ANYTHING, np.int32)
    stepped = np.zeros(order.shape[0], np.int32)
    waiting = 0
    for n in range(order.shape[0]):
        task, number = order[n] // model.widest, order[n] % model.widest
        chosen = model.task_first[task] + alternative[task]
        if number < model.leg_first[chosen + 1] - model.leg_first[chosen]:
            legs[waiting], places[waiting] = model.leg_first[chosen] + number, order[n]
            waiting += 1
    length, ways_made = 0, 0
    most_ways = 2 * waiting + 2 * free.shape[0]
    n, anyone = 0, False
    while waiting > 0:
        if n < waiting:
            mover = agent[places[n]]
            if mover >= 0 and aside[places[n]] > 0 and stepped[n] == 0:
                stepped[n] = 1
                length += _leave(
                    model, mover, aside[places[n]], ANYTHING, team, facts, free, configuration, log,
                    out_steps, out_team, length,
                )  # fmt: skip
            if anyone or waits_for[n] == ANYTHING or facts[waits_for[n], HOLDS] == 1.0:
                now, end = place_leg(
                    model, legs[n], agent[places[n]], anyone, team, facts, free, configuration, role_agent, log,
                    out_steps, out_team, length,
                )  # fmt: skip
                if now >= 0:
                    length = now
                    taken[places[n]] = team[0]
                    task = places[n] // model.widest
                    ends[task] = max(ends[task], end)
                    waiting -= 1
                    for m in range(n, waiting):
                        legs[m], places[m] = legs[m + 1], places[m + 1]
                        waits_for[m], stepped[m] = waits_for[m + 1], stepped[m + 1]
                    n, anyone = 0, False
                    continue
                if not anyone:
                    waits_for[n] = int(end)
            n += 1
            continue
        n, anyone = 0, not anyone
        if anyone:
            continue
        made = False
        for m in range(waiting * free.shape[0]):
            fact, one = waits_for[m // free.shape[0]], m % free.shape[0]
            if fact != ANYTHING and ways_made < most_ways and not made:
                made = _leave(
                    model, one, ANYWHERE, fact, team, facts, free, configuration, log, out_steps, out_team, length
                )  # fmt: skip
        if not made:
            stuck[0] = waits_for[0]
            for m in range(waiting):
                if waits_for[m] != ANYTHING and model.fact_by_setup[waits_for[m]]:
                    stuck[0] = waits_for[m]
                    break
            return IMPOSSIBLE, length, 0.0
        ways_made += 1
        length += 1
    stuck[0] = ANYTHING
    return _cost(model, facts, free, configuration, ends, weights, length, out_steps)


@inlined
def _cost(model, facts, free, configuration, ends, weights, length, out_steps):  # type: ignore[no-untyped-def]
    for n in range(model.goal_facts.shape[0]):
        if facts[model.goal_facts[n], HOLDS] == 0.0:
            return IMPOSSIBLE, length, 0.0
    for n in range(model.posture_agent.shape[0]):
        way = model.way[configuration[model.posture_agent[n]], model.posture_need[n]]
        if way == UNREACHABLE or model.way_first[way] != model.way_first[way + 1]:
            return IMPOSSIBLE, length, 0.0
    makespan, used, late, energy = 0.0, 0, 0.0, 0.0
    for agent in range(free.shape[0]):
        makespan = max(makespan, free[agent])
        used += 1 if free[agent] > 0.0 else 0
    for n in range(length):
        energy += model.step_energy_j[out_steps[n]]
    for task in range(ends.shape[0]):
        late += model.task_weight[task] * max(0.0, ends[task] - model.task_deadline_s[task])
    cost = weights[0] * makespan + weights[1] * energy + weights[2] * used + weights[3] * late
    return cost + weights[4] * ends.sum(), length, makespan
