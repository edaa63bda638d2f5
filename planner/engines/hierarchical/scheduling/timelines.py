"""Timelines of agents and shared facts: when a step can start, and what it leaves behind. Compiled (numba)."""

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
from planner.engines.hierarchical.scheduling.model import HEADER, MAX_AGENTS


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
