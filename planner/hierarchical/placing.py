"""Placing legs on the timelines of agents and shared facts, one step after the other.

A placed step starts as soon as its agents, the facts it needs and those whose use it ends allow: deletes at its start,
effects at its end, as a plan-net has it. Agents take legs by who can begin first.

Compiled (numba), hence arrays and numbers only. A shared fact's state is a row (holds, since, until, gone, by): 1 or 0;
in seconds the end of the step that brought it about, of the last one that needs it and of the one that deleted it; the
agent that deleted it.
"""

import numpy as np

from planner.hierarchical.compiled import inlined, kernel
from planner.hierarchical.model import HEADER, MOST_AGENTS, UNREACHABLE

HOLDS, SINCE, UNTIL, GONE, BY = range(5)
ANYWHERE, BACK, NEAR = range(3)
ANYTHING = -1  # a leg waits for nothing in particular


@kernel
def _place(step_at, step_data, step_span_s, step, team, facts, free, log, count):  # type: ignore[no-untyped-def]
    """Place one step of the team: (its end, the log's new length), or (-1 - fact, length) where a fact is missing."""
    at = step_at[step]
    mask = step_data[at]
    needs = at + HEADER
    deletes = needs + step_data[at + 1]
    adds = deletes + step_data[at + 2]
    end_of_adds = adds + step_data[at + 3]
    start = 0.0
    for slot in range(MOST_AGENTS):
        if mask >> slot & 1:
            start = max(start, free[team[slot]])
    for n in range(needs, deletes):
        if facts[step_data[n], HOLDS] == 0.0:
            return -1.0 - step_data[n], count
        start = max(start, facts[step_data[n], SINCE])
    for n in range(deletes, adds):
        if facts[step_data[n], HOLDS] == 1.0:
            start = max(start, facts[step_data[n], UNTIL])
    for n in range(adds, end_of_adds):
        if facts[step_data[n], HOLDS] == 0.0:
            start = max(start, facts[step_data[n], GONE])
    end = start + step_span_s[step]
    for n in range(needs, end_of_adds):
        fact = step_data[n]
        log[count, 0] = fact
        log[count, 1:] = facts[fact]
        count += 1
    for n in range(needs, deletes):
        facts[step_data[n], UNTIL] = max(facts[step_data[n], UNTIL], end)
    for n in range(deletes, adds):
        if facts[step_data[n], HOLDS] == 1.0:
            facts[step_data[n], HOLDS], facts[step_data[n], GONE] = 0.0, end
            facts[step_data[n], BY] = team[0]
    for n in range(adds, end_of_adds):
        if facts[step_data[n], HOLDS] == 0.0:
            fact = step_data[n]
            facts[fact, HOLDS], facts[fact, SINCE], facts[fact, UNTIL] = 1.0, end, end
    for slot in range(MOST_AGENTS):
        if mask >> slot & 1:
            free[team[slot]] = end
    return end, count


@inlined
def _first_in_line(members, way, way_span_s, need, team, slot, free, configuration, ready):  # type: ignore[no-untyped-def]
    """The agent of the class that can begin first, the nearest among equals; -1 where nobody can."""
    best, best_start, best_span = -1, 0.0, 0.0
    for agent in members:
        found = way[configuration[agent], need]
        if found == UNREACHABLE or (slot > 0 and agent in team[:slot]):
            continue
        span = way_span_s[found]
        start = max(free[agent] + span, ready)
        if best < 0 or (start, span) < (best_start, best_span):
            best, best_start, best_span = agent, start, span
    return best


@inlined
def _choose(model, leg, wanted, team, facts, free, configuration, role_agent):  # type: ignore[no-untyped-def]
    """Fill in the leg's team, bound slots and roles as they are; False where a slot has nobody."""
    ready = 0.0
    first = model.slot_first[leg]
    if model.core_first[leg] < model.core_first[leg + 1]:
        at = model.step_at[model.core_steps[model.core_first[leg]]]
        for n in range(at + HEADER, at + HEADER + model.step_data[at + 1]):
            ready = max(ready, facts[model.step_data[n], SINCE])
    for slot in range(model.slot_first[leg + 1] - first):
        place = first + slot
        need, kind = model.slot_need[place], model.slot_class[place]
        agent = model.slot_agent[place]
        if agent < 0:
            agent = role_agent[model.slot_role[place]]
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
                members, model.way, model.way_span_s, need, team, slot, free, configuration, ready
            )
        if agent < 0 or model.way[configuration[agent], need] == UNREACHABLE:
            return False
        team[slot] = agent
    return True


@inlined
def _missing_at_once(model, leg, facts):  # type: ignore[no-untyped-def]
    """A fact that the leg's core needs first and that no way there can bring about, ANYTHING if none is missing."""
    if model.core_first[leg] < model.core_first[leg + 1]:
        at = model.step_at[model.core_steps[model.core_first[leg]]]
        for n in range(at + HEADER, at + HEADER + model.step_data[at + 1]):
            fact = model.step_data[n]
            if facts[fact, HOLDS] == 0.0 and model.fact_by_setup[fact] == 0:
                return fact
    return ANYTHING


@inlined
def place_leg(  # type: ignore[no-untyped-def]
    model, leg, wanted, anyone, team, facts, free, configuration, role_agent, log, out_steps, out_team, length
):
    """Place a leg with its ways: (the output's new length, its end), or (-1, the fact missing or ANYTHING).

    :param anyone: True: where an agent stands in the way, try whether it can do the leg itself.
    """
    missing = _missing_at_once(model, leg, facts)
    if missing != ANYTHING:
        return -1, float(missing)
    if not _choose(model, leg, wanted, team, facts, free, configuration, role_agent):
        return -1, float(ANYTHING)
    first = model.slot_first[leg]
    slots = model.slot_first[leg + 1] - first
    at, data, spans = model.step_at, model.step_data, model.step_span_s
    before = np.empty((2, MOST_AGENTS))
    begun, last = length, 0.0
    for attempt in range(2):
        for slot in range(slots):
            before[0, slot], before[1, slot] = free[team[slot]], configuration[team[slot]]
        count, end, last, length = 0, 0.0, 0.0, begun
        for slot in range(slots):
            way = model.way[configuration[team[slot]], model.slot_need[first + slot]]
            for n in range(model.way_first[way], model.way_first[way + 1]):
                step = model.way_steps[n]
                end, count = _place(at, data, spans, step, team[slot:], facts, free, log, count)
                if end < 0.0:
                    break
                out_steps[length], out_team[length, 0] = step, team[slot]
                length += 1
                last = max(last, end)
            if end < 0.0:
                break
            configuration[team[slot]] = model.way_end[way]
        if end >= 0.0:
            for n in range(model.core_first[leg], model.core_first[leg + 1]):
                step = model.core_steps[n]
                end, count = _place(at, data, spans, step, team, facts, free, log, count)
                if end < 0.0:
                    break
                out_steps[length] = step
                out_team[length] = team
                length += 1
                last = max(last, end)
        if end >= 0.0:
            break
        for n in range(count - 1, -1, -1):
            facts[int(log[n, 0])] = log[n, 1:]
        for slot in range(slots):
            free[team[slot]], configuration[team[slot]] = before[0, slot], int(before[1, slot])
        missing = int(-1.0 - end)
        holder = int(facts[missing, BY])
        if (
            attempt > 0
            or not anyone
            or holder < 0
            or holder == team[0]
            or slots > 1
            or model.slot_agent[first] >= 0
            or role_agent[model.slot_role[first]] >= 0
            or model.agent_class[holder] != model.slot_class[first]
            or model.way[configuration[holder], model.slot_need[first]] == UNREACHABLE
        ):
            return -1, float(missing)
        team[0] = holder  # who is in the way may be able to do it itself
    for slot in range(slots):
        place = first + slot
        role_agent[model.slot_role[place]] = team[slot]
        configuration[team[slot]] = model.after[configuration[team[slot]], model.slot_effect[place]]
    return length, last


def leave(model, agent, where, fact, team, facts, free, configuration, log, out_steps, out_team, length):  # type: ignore[no-untyped-def]
    """Have the agent leave where it stands, so that the fact comes about (ANYTHING: whatever); True if it could.

    :param where: BACK to where it stood at first, NEAR to the nearest place, or ANYWHERE of these.
    """
    here = configuration[agent]
    near = model.near_first[here + 1] - model.near_first[here] if where != BACK else 0
    back = model.leave_first[agent + 1] - model.leave_first[agent] if where != NEAR else 0
    for n in range(near + back):
        if n < near:
            way = model.near_ways[model.near_first[here] + n]
        else:
            own = model.leave_first[agent] + n - near
            if model.leave_from[own] != here:
                continue
            way = model.leave_ways[own]
        step = model.way_steps[model.way_first[way]]
        at = model.step_at[step]
        adds = at + HEADER + model.step_data[at + 1] + model.step_data[at + 2]
        if fact != ANYTHING and fact not in model.step_data[adds : adds + model.step_data[at + 3]]:
            continue
        team[0] = agent
        end, _ = _place(model.step_at, model.step_data, model.step_span_s, step, team, facts, free, log, 0)
        if end >= 0.0:
            out_steps[length], out_team[length, 0] = step, agent
            configuration[agent] = model.way_end[way]
            return True
    return False
