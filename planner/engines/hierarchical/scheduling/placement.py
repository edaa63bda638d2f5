"""Placing legs on the timelines of agents and shared facts, one step after the other.

A placed step starts as soon as its agents, the facts it needs and those whose use it ends allow: deletes at its start,
effects at its end, as a plan-net has it. Agents take legs by who can begin first.

Compiled (numba), hence arrays and numbers only.
"""

from planner.compiled import inlined, lean
from planner.engines.hierarchical.scheduling.decoder_state import (
    BY,
    COLUMNS,
    FREE,
    GONE,
    GONE_AT,
    HOLDS,
    LAST,
    NONE,
    SINCE,
    SINCE_AT,
    UNTIL,
    UNTIL_AT,
)
from planner.engines.hierarchical.scheduling.model import AHEAD, BACK, HEADER, MAX_AGENTS, NEAR, UNREACHABLE


@inlined
def _first_possible(data, needs, deletes, adds, end_of_adds, mask, team, facts, free):  # type: ignore[no-untyped-def]
    """When facts and agents allow a step, and the step that keeps it from starting earlier; (-1, the fact) if one is
    missing. Of what allows it at the same time the agents count, then the facts it needs."""
    start = 0.0
    by = float(NONE)
    for n in range(needs, deletes):
        fact = data[n]
        if facts[fact, HOLDS] == 0.0:
            return -1.0, float(fact)
        if facts[fact, SINCE] > start:
            start = facts[fact, SINCE]
            by = facts[fact, SINCE_AT]
    for n in range(deletes, adds):
        fact = data[n]
        if facts[fact, HOLDS] == 1.0 and facts[fact, UNTIL] > start:
            start = facts[fact, UNTIL]
            by = facts[fact, UNTIL_AT]
    for n in range(adds, end_of_adds):
        fact = data[n]
        if facts[fact, HOLDS] == 0.0 and facts[fact, GONE] > start:
            start = facts[fact, GONE]
            by = facts[fact, GONE_AT]
    for slot in range(MAX_AGENTS):
        if mask >> slot & 1 and free[team[slot], FREE] >= start:
            start = free[team[slot], FREE]
            by = free[team[slot], LAST]
    return start, by


@inlined
def _change(data, needs, deletes, adds, end_of_adds, facts, agent, number, end):  # type: ignore[no-untyped-def]
    """What a step of this number and end does to the facts."""
    for n in range(needs, deletes):
        fact = data[n]
        if end > facts[fact, UNTIL]:
            facts[fact, UNTIL] = end
            facts[fact, UNTIL_AT] = number
    for n in range(deletes, adds):
        fact = data[n]
        if facts[fact, HOLDS] == 1.0:
            facts[fact, HOLDS] = 0.0
            facts[fact, GONE] = end
            facts[fact, BY] = agent
            facts[fact, GONE_AT] = number
    for n in range(adds, end_of_adds):
        fact = data[n]
        if facts[fact, HOLDS] == 0.0:
            facts[fact, HOLDS] = 1.0
            facts[fact, SINCE] = end
            facts[fact, UNTIL] = end
            facts[fact, SINCE_AT] = number
            facts[fact, UNTIL_AT] = number


@lean
def place(step_at, data, step_span_s, step, team, facts, free, cause, number, log, count):  # type: ignore[no-untyped-def]
    """Place one step of the team: (its end, the log's new length), or (-1 - fact, length) where a fact is missing."""
    at = step_at[step]
    mask = data[at]
    needs = at + HEADER
    deletes = needs + data[at + 1]
    adds = deletes + data[at + 2]
    end_of_adds = adds + data[at + 3]
    start, by = _first_possible(data, needs, deletes, adds, end_of_adds, mask, team, facts, free)
    if start < 0.0:
        return -1.0 - by, count
    end = start + step_span_s[step]
    cause[number] = int(by)
    for n in range(needs, end_of_adds):
        log[count, 0] = data[n]
        for column in range(COLUMNS):
            log[count, 1 + column] = facts[data[n], column]
        count += 1
    _change(data, needs, deletes, adds, end_of_adds, facts, team[0], number, end)
    for slot in range(MAX_AGENTS):
        if mask >> slot & 1:
            free[team[slot], FREE] = end
            free[team[slot], LAST] = number
    return end, count


@inlined
def ready_s(step_at, step_data, step, facts):  # type: ignore[no-untyped-def]
    """When the shared facts allow a step, -1 where one is missing."""
    at = step_at[step]
    deletes = at + HEADER + step_data[at + 1]
    ready = 0.0
    for n in range(at + HEADER, deletes):
        if facts[step_data[n], HOLDS] == 0.0:
            ready = -1.0
            break
        ready = max(ready, facts[step_data[n], SINCE])
    if ready >= 0.0:
        for n in range(deletes, deletes + step_data[at + 2]):
            if facts[step_data[n], HOLDS] == 1.0:
                ready = max(ready, facts[step_data[n], UNTIL])
    return ready


@inlined
def _way_ready_s(model, way, facts):  # type: ignore[no-untyped-def]
    """When the shared facts allow a way to begin, -1 where one is missing."""
    ready = 0.0
    driven = 0.0
    for n in range(model.way_first[way], model.way_first[way + 1]):
        step = model.way_steps[n]
        allowed = ready_s(model.step_at, model.step_data, step, facts)
        if allowed < 0.0:
            ready = -1.0
            break
        ready = max(ready, allowed - driven)
        driven += model.step_span_s[step]
    return ready


@inlined
def _brings_about(model, way, fact):  # type: ignore[no-untyped-def]
    """Whether one of a way's steps has the fact as an effect."""
    found = False
    for n in range(model.way_first[way], model.way_first[way + 1]):
        at = model.step_at[model.way_steps[n]]
        adds = at + HEADER + model.step_data[at + 1] + model.step_data[at + 2]
        found = found or fact in model.step_data[adds : adds + model.step_data[at + 3]]
    return found


@inlined
def _first_in_line(members, way, way_span_s, need, team, slot, free, configuration, ready):  # type: ignore[no-untyped-def]
    """The agent of the class that can begin first, the nearest among equals; -1 where nobody can."""
    best = -1
    best_start = 0.0
    best_span = 0.0
    for agent in members:
        found = way[configuration[agent], need]
        if found == UNREACHABLE or (slot > 0 and agent in team[:slot]):
            continue
        span = way_span_s[found]
        start = max(free[agent, FREE] + span, ready)
        if best < 0 or (start, span) < (best_start, best_span):
            best = agent
            best_start = start
            best_span = span
    return best


@inlined
def _choose(model, state, leg, wanted):  # type: ignore[no-untyped-def]
    """Fill in the leg's team, bound slots and roles as they are; False where a slot has nobody."""
    ready = 0.0
    first = model.slot_first[leg]
    team = state.team
    configuration = state.configuration
    if model.core_first[leg] < model.core_first[leg + 1]:
        at = model.step_at[model.core_steps[model.core_first[leg]]]
        for n in range(at + HEADER, at + HEADER + model.step_data[at + 1]):
            ready = max(ready, state.facts[model.step_data[n], SINCE])
    for slot in range(model.slot_first[leg + 1] - first):
        place = first + slot
        need = model.slot_need[place]
        kind = model.slot_class[place]
        agent = model.slot_agent[place]
        if agent < 0:
            agent = state.role_agent[model.slot_role[place]]
        free_to_choose = agent < 0 and slot == 0 and wanted >= 0
        if (
            free_to_choose
            and model.agent_class[wanted] == kind
            and model.way[configuration[wanted], need] >= 0
        ):
            agent = wanted
        if agent < 0:
            members = model.members[model.member_first[kind] : model.member_first[kind + 1]]
            agent = _first_in_line(
                members, model.way, model.way_span_s, need, team, slot, state.free, configuration, ready
            )
        if agent < 0 or model.way[configuration[agent], need] == UNREACHABLE:
            return False
        team[slot] = agent
    return True


@inlined
def _missing_at_once(model, leg, facts):  # type: ignore[no-untyped-def]
    """A fact that the leg's core needs first and that no way there can bring about, NONE if none is missing."""
    if model.core_first[leg] < model.core_first[leg + 1]:
        at = model.step_at[model.core_steps[model.core_first[leg]]]
        for n in range(at + HEADER, at + HEADER + model.step_data[at + 1]):
            fact = model.step_data[n]
            if facts[fact, HOLDS] == 0.0 and model.fact_by_setup[fact] == 0:
                return fact
    return NONE


@inlined
def _stop(model, state, agent, need, where):  # type: ignore[no-untyped-def]
    """The way to a stop on the agent's way to a need, -1 if none is free and worth it; of several the soonest.

    :param where: NEAR to here, BACK where it stood at first, or AHEAD, near to where it is needed.
    """
    here = state.configuration[agent]
    whole = model.way_span_s[model.way[here, need]]
    best = NONE
    best_end = 0.0
    if where == NEAR:
        first = model.near_first[here]
        last = model.near_first[here + 1]
    elif where == BACK:
        first = model.leave_first[agent]
        last = model.leave_first[agent + 1]
    else:
        first = model.ahead_first[need]
        last = model.ahead_first[need + 1]
    for n in range(first, last):
        if where == NEAR:
            way = model.near_ways[n]
        elif where == BACK:
            way = model.leave_ways[n] if model.leave_from[n] == here else NONE
        else:
            way = model.way[here, model.ahead_needs[n]]
        if way < 0 or model.way_actions[way] != 1:
            continue
        rest = model.way[model.way_end[way], need]
        if rest == UNREACHABLE:
            continue
        part = model.way_span_s[rest] if where == AHEAD else model.way_span_s[way]
        if part * 2.0 > whole:
            continue
        ready = _way_ready_s(model, way, state.facts)
        if ready < 0.0:
            continue
        end = max(ready, state.free[agent, FREE]) + model.way_span_s[way] + model.way_span_s[rest]
        if best < 0 or end < best_end:
            best = way
            best_end = end
    return best


@inlined
def _note(state, length, step, agent, key):  # type: ignore[no-untyped-def]
    """Write down a step of one agent."""
    state.steps[length] = step
    state.step_agents[length, 0] = agent
    state.step_leg[length] = key


@inlined
def _go(model, state, way, slot, key, length, count):  # type: ignore[no-untyped-def]
    """Take the agent of a slot along a way: (its end or -1 - fact, steps, the log's length)."""
    end = 0.0
    for n in range(model.way_first[way], model.way_first[way + 1]):
        step = model.way_steps[n]
        end, count = place(
            model.step_at, model.step_data, model.step_span_s, step, state.team[slot:], state.facts,
            state.free, state.cause, length, state.log, count,
        )  # fmt: skip
        if end < 0.0:
            break
        _note(state, length, step, state.team[slot], key)
        length += 1
    if end >= 0.0:
        state.configuration[state.team[slot]] = model.way_end[way]
    return end, length, count


@inlined
def _work(model, state, leg, key, length, count):  # type: ignore[no-untyped-def]
    """Place the core of a leg: (its end or -1 - fact, steps, the log's length)."""
    end = 0.0
    last = 0.0
    for n in range(model.core_first[leg], model.core_first[leg + 1]):
        step = model.core_steps[n]
        end, count = place(
            model.step_at, model.step_data, model.step_span_s, step, state.team, state.facts,
            state.free, state.cause, length, state.log, count,
        )  # fmt: skip
        if end < 0.0:
            break
        _note(state, length, step, state.team[0], key)
        for slot in range(1, MAX_AGENTS):
            state.step_agents[length, slot] = state.team[slot]
        length += 1
        last = max(last, end)
    return (end if end < 0.0 else last), length, count


@inlined
def _attempt(model, state, leg, key, stops, length):  # type: ignore[no-untyped-def]
    """Place a leg with the team as it is: (its end or -1 - fact, steps, the log's length)."""
    first = model.slot_first[leg]
    end = 0.0
    last = 0.0
    count = 0
    for slot in range(model.slot_first[leg + 1] - first):
        agent = state.team[slot]
        need = model.slot_need[first + slot]
        if slot == 0:
            if stops & (BACK | NEAR):
                stop = _stop(model, state, agent, need, stops & (BACK | NEAR))
                if stop >= 0:
                    end, length, count = _go(model, state, stop, slot, key, length, count)
            if stops & AHEAD:
                stop = _stop(model, state, agent, need, AHEAD)
                if stop >= 0:
                    end, length, count = _go(model, state, stop, slot, key, length, count)
        way = model.way[state.configuration[agent], need]
        end, length, count = _go(model, state, way, slot, key, length, count)
        if end < 0.0:
            break
        last = max(last, end)
    if end >= 0.0:
        end, length, count = _work(model, state, leg, key, length, count)
        end = max(last, end) if end >= 0.0 else end
    return end, length, count


@inlined
def _may_do_itself(model, state, leg, holder):  # type: ignore[no-untyped-def]
    """Whether an agent in a leg's way could carry it out."""
    first = model.slot_first[leg]
    return (
        holder >= 0
        and holder != state.team[0]
        and model.slot_first[leg + 1] - first == 1
        and model.slot_agent[first] < 0
        and state.role_agent[model.slot_role[first]] < 0
        and model.agent_class[holder] == model.slot_class[first]
        and model.way[state.configuration[holder], model.slot_need[first]] != UNREACHABLE
    )


@inlined
def take_back(model, state, leg):  # type: ignore[no-untyped-def]
    """Undo the placing of a leg, the last one that was placed or tried."""
    first = model.slot_first[leg]
    for n in range(state.logged[0] - 1, -1, -1):
        for column in range(COLUMNS):
            state.facts[int(state.log[n, 0]), column] = state.log[n, 1 + column]
    for slot in range(model.slot_first[leg + 1] - first):
        agent = state.team[slot]
        state.free[agent, FREE] = state.before[0, slot]
        state.free[agent, LAST] = state.before[1, slot]
        state.configuration[agent] = int(state.before[2, slot])
        state.role_agent[model.slot_role[first + slot]] = int(state.before[3, slot])


@inlined
def place_leg(model, state, leg, key, wanted, stops, anyone, length):  # type: ignore[no-untyped-def]
    """Place a leg with its ways: (the number of steps then, its end), or (-1, the fact missing or NONE).

    :param anyone: True: where an agent stands in the way, try whether it can do the leg itself.
    """
    facts = state.facts
    free = state.free
    configuration = state.configuration
    team = state.team
    missing = _missing_at_once(model, leg, facts)
    if missing != NONE:
        return -1, float(missing)
    if not _choose(model, state, leg, wanted):
        return -1, float(NONE)
    first = model.slot_first[leg]
    slots = model.slot_first[leg + 1] - first
    before = state.before
    for attempt in range(2):
        for slot in range(slots):
            before[0, slot] = free[team[slot], FREE]
            before[1, slot] = free[team[slot], LAST]
            before[2, slot] = configuration[team[slot]]
            before[3, slot] = state.role_agent[model.slot_role[first + slot]]
        end, now, state.logged[0] = _attempt(model, state, leg, key, stops, length)
        if end >= 0.0:
            for slot in range(slots):
                state.role_agent[model.slot_role[first + slot]] = team[slot]
                configuration[team[slot]] = model.after[
                    configuration[team[slot]], model.slot_effect[first + slot]
                ]
            return now, end
        take_back(model, state, leg)
        missing = int(-1.0 - end)
        holder = int(facts[missing, BY])
        if attempt > 0 or not anyone or not _may_do_itself(model, state, leg, holder):
            break
        team[0] = holder
    return -1, float(missing)


def leave(model, state, agent, fact, key, length, home):  # type: ignore[no-untyped-def]
    """Have the agent leave where it stands, so that the fact comes about: the number of steps then, -1 if it cannot.

    :param home: True: rather to where it stood at first than to a near place.
    """
    here = state.configuration[agent]
    near = model.near_first[here + 1] - model.near_first[here]
    back = model.leave_first[agent + 1] - model.leave_first[agent]
    for turn in range(near + back):
        n = (turn + near) % (near + back) if home else turn
        if n < near:
            way = model.near_ways[model.near_first[here] + n]
        else:
            own = model.leave_first[agent] + n - near
            if model.leave_from[own] != here:
                continue
            way = model.leave_ways[own]
        if not _brings_about(model, way, fact) or _way_ready_s(model, way, state.facts) < 0.0:
            continue
        state.team[0] = agent
        _, length, _ = _go(model, state, way, 0, key, length, 0)
        return length
    return -1
