"""Serial schedule generation: from priorities to a schedule. Compiled (numba).

The legs are taken by priority; a leg that cannot be placed yet (a fact it needs does not hold after the legs placed so
far) waits until it does. Where no leg can be placed, an agent that stands in the way makes way.
"""

from planner.compiled import inlined, lean
from planner.engines.hierarchical.scheduling.decoder_state import BY, COLUMNS, FREE, HOLDS, LAST, NONE
from planner.engines.hierarchical.scheduling.model import (
    GOES_ON,
    HEADER,
    ITSELF,
    PUSH,
    STRICT,
    UNREACHABLE,
)
from planner.engines.hierarchical.scheduling.placement import leave, place_leg

IMPOSSIBLE = 1e18
"""The cost of a choice that cannot be scheduled."""
USELESS = 1e15
"""What each useless step adds to the decisive cost …"""
USELESS_SHARE = 0.02
"""… and by what share it raises the other, so that the search may pass by such schedules."""
LEGS, PLACES, WAITS_FOR = range(3)

_leave = lean(leave)


@lean
def decode(model, choice, weights, most, state):  # type: ignore[no-untyped-def]
    """Schedule the choice on the state.

    :param weights: (2, 5) of a second of makespan, a joule, an agent used, a second of weighted lateness, and a second
        of all tasks' ends together; first what decides, then what breaks ties.
    :param most: what the choice may cost with what breaks ties; above it, it counts as impossible.
    :returns: the cost without and with what breaks ties, the number of steps placed, the makespan in seconds.
    """
    waiting = _begin(model, choice, state)
    facts = state.facts
    ends = state.ends
    legs = state.waiting[LEGS]
    places = state.waiting[PLACES]
    waits_for = state.waiting[WAITS_FOR]
    length = 0
    ways_made = 0
    n = 0
    anyone = False
    most_ways = 2 * (waiting + state.free.shape[0])
    while waiting > 0:
        if n < waiting:
            if anyone or waits_for[n] == NONE or facts[waits_for[n], HOLDS] == 1.0:
                place = places[n]
                now, end = place_leg(
                    model, state, legs[n], place, choice.agent[place], choice.stops[place], anyone, length
                )
                if now >= 0:
                    if weights[0, 0] * end > most:
                        return IMPOSSIBLE, IMPOSSIBLE, length, 0.0
                    length = now
                    state.taken[place] = state.team[0]
                    ends[place // model.max_legs] = max(ends[place // model.max_legs], end)
                    waiting -= 1
                    for m in range(n, waiting):
                        legs[m], places[m], waits_for[m] = legs[m + 1], places[m + 1], waits_for[m + 1]
                    n = 0
                    anyone = False
                    continue
                if not anyone:
                    waits_for[n] = int(end)
                    if choice.stops[place] & PUSH and ways_made < most_ways and waits_for[n] != NONE:
                        holder = int(facts[waits_for[n], BY])
                        home = choice.stops[place] & STRICT > 0
                        now = -1
                        if holder >= 0:
                            now = _leave(model, state, holder, waits_for[n], place, length, home)
                        if now >= 0:
                            ways_made += 1
                            length = now
                            continue
            n = waiting if choice.stops[places[n]] & STRICT else n + 1
            continue
        n = 0
        anyone = not anyone
        if anyone:
            continue
        now = -1
        if ways_made < most_ways:
            now = make_way(model, state, choice.stops, waits_for[:waiting], places, length)
        if now < 0:
            state.missing_fact[0] = _hopeless(model, waits_for[:waiting])
            return IMPOSSIBLE, IMPOSSIBLE, length, 0.0
        ways_made += 1
        length = now
    return _cost(model, state, weights, length)


@inlined
def _begin(model, choice, state):  # type: ignore[no-untyped-def]
    """Clear the state and put down the chosen legs by priority; how many."""
    clear(model, state)
    count = 0
    for place in choice.order:
        chosen = model.task_first[place // model.max_legs] + choice.alternative[place // model.max_legs]
        leg = model.leg_first[chosen] + place % model.max_legs
        if leg < model.leg_first[chosen + 1]:
            state.waiting[LEGS, count] = leg
            state.waiting[PLACES, count] = place
            state.waiting[WAITS_FOR, count] = NONE
            count += 1
    return count


@inlined
def clear(model, state):  # type: ignore[no-untyped-def]
    """Bring the state back to where nothing is placed."""
    for fact in range(state.facts.shape[0]):
        state.facts[fact, HOLDS] = model.fact_true[fact]
        for column in range(1, COLUMNS):
            state.facts[fact, column] = 0.0 if column < BY else float(NONE)
    for n in range(model.hold_facts.shape[0]):
        state.facts[model.hold_facts[n], BY] = model.hold_agents[n]
    for agent in range(state.free.shape[0]):
        state.free[agent, FREE] = 0.0
        state.free[agent, LAST] = float(NONE)
        state.configuration[agent] = model.agent_start[agent]
    state.role_agent[:] = NONE
    state.ends[:] = 0.0
    state.missing_fact[0] = NONE


@inlined
def make_way(model, state, stops, waits_for, places, length):  # type: ignore[no-untyped-def]
    """Have somebody bring about a fact that a leg waits for, by leaving: the number of steps then, -1 if nobody can."""
    for m in range(waits_for.shape[0]):
        for agent in range(state.free.shape[0]):
            home = stops[places[m]] & STRICT > 0
            if waits_for[m] != NONE:
                now = _leave(model, state, agent, waits_for[m], places[m], length, home)
                if now >= 0:
                    return now
    return -1


@inlined
def _hopeless(model, waits_for):  # type: ignore[no-untyped-def]
    """The fact that legs wait for in vain, one that setups can bring about before others."""
    for fact in waits_for:
        if fact != NONE and model.fact_by_setup[fact]:
            return fact
    return waits_for[0]


@inlined
def _cost(model, state, weights, length):  # type: ignore[no-untyped-def]
    for fact in model.goal_facts:
        if state.facts[fact, HOLDS] == 0.0:
            return IMPOSSIBLE, IMPOSSIBLE, length, 0.0
    for n in range(model.final_agent.shape[0]):
        way = model.way[state.configuration[model.final_agent[n]], model.final_need[n]]
        if way == UNREACHABLE or model.way_first[way] != model.way_first[way + 1]:
            return IMPOSSIBLE, IMPOSSIBLE, length, 0.0
    makespan = 0.0
    used = 0
    late = 0.0
    energy = 0.0
    for agent in range(state.free.shape[0]):
        makespan = max(makespan, state.free[agent, FREE])
        used += 1 if state.free[agent, FREE] > 0.0 else 0
    for n in range(length):
        energy += model.step_energy_j[state.steps[n]]
    for task in range(state.ends.shape[0]):
        late += model.task_weight[task] * max(0.0, state.ends[task] - model.task_deadline_s[task])
    ends = state.ends.sum()
    decisive = (
        weights[0, 0] * makespan
        + weights[0, 1] * energy
        + weights[0, 2] * used
        + weights[0, 3] * late
        + weights[0, 4] * ends
    )
    ties = (
        weights[1, 0] * makespan
        + weights[1, 1] * energy
        + weights[1, 2] * used
        + weights[1, 3] * late
        + weights[1, 4] * ends
    )
    useless = _useless(model, state, length)
    cost = (decisive + ties) * (1.0 + USELESS_SHARE * useless)
    return decisive + USELESS * useless, cost, length, makespan


@inlined
def _useless(model, state, length):  # type: ignore[no-untyped-def]
    """The number of steps without a use: they are redundant, or there for what table 3 does not allow."""
    count = 0
    for n in range(length):
        step = state.steps[n]
        use = model.step_use[step]
        if use == ITSELF or (use == GOES_ON and state.free[state.step_agents[n, 0], LAST] != n):
            continue
        is_used = False
        for m in range(model.final_agent.shape[0] if use == GOES_ON else 0):
            is_used = is_used or model.final_agent[m] == state.step_agents[n, 0]
        for m in range(model.excuse_first[step], model.excuse_first[step + 1]):
            if is_used:
                break
            fact = model.excuses[m]
            for later in range(n + 1, length):
                at = model.step_at[state.steps[later]]
                deletes = at + HEADER + model.step_data[at + 1]
                if fact in model.step_data[at + HEADER : deletes]:
                    is_used = True
                    break
                if fact in model.step_data[deletes : deletes + model.step_data[at + 2]]:
                    break
        count += 0 if is_used else 1
    return count
