"""Deliberation cycles a second on one core: `python -m benchmarks.deliberation`.

Each agent has 30 rules and, unless said otherwise, 100 beliefs; in every cycle some of its beliefs change, which makes
commitments of rules that hold then. CPU time of this process, without sensing.
"""

import argparse
import sys
from time import process_time

from robots.deliberative.actuators import DONE, Activation, Attempt, Outcome, Utterance
from robots.deliberative.agent import Agent
from robots.deliberative.program import RuleFile, Verb
from robots.deliberative.reader import rules_of
from robots.deliberative.terms import Term

AGENTS = 1000
RULES = 30
BELIEFS = 100
CHANGES = 4
CYCLES = 20


class Nothing:
    """A robot on which every action succeeds at once."""

    def activate(self, wanted: Activation) -> Attempt | Outcome | None:
        return DONE

    def say(self, utterance: Utterance) -> Outcome:
        return DONE

    def steer(self, verb: Verb, reason: str) -> Outcome:
        return DONE


def lasting(rules: int, beliefs: int) -> list[Term]:
    """Where each of some things is, and of which kind."""
    things = range(beliefs // 2)
    at = [Term("at", (f"thing_{number}", f"place_{number % 10}")) for number in things]
    return at + [Term("kind", (f"thing_{number}", f"kind_{number % rules}")) for number in things]


def rule_file(rules: int) -> RuleFile:
    """Rules that join an event with two beliefs that last, and refuse a third."""
    lines = ["AGENT measured;", "ACTUATOR say;"]
    for number in range(rules):
        lines.append(
            f"BELIEF(event(?thing, kind_{number})) & BELIEF(kind(?thing, kind_{number})) & "
            f"BELIEF(at(?thing, ?place)) & !BELIEF(closed(?place)) "
            f"=> COMMIT(say(inform, operator, found(?thing, ?place)));"
        )
    return rules_of("\n".join(lines), "measured.rules")


def cycle_s(agents: int, rules: int, beliefs: int, changes: int, cycles: int) -> float:
    """CPU seconds of one agent's cycle."""
    file = rule_file(rules)
    known = lasting(rules, beliefs)
    team = [Agent("measured", [file], Nothing(), known=known) for _ in range(agents)]
    things = beliefs // 2
    events = [
        [
            Term("event", (f"thing_{number % things}", f"kind_{number % things % rules}"))
            for number in range(cycle * changes, (cycle + 1) * changes)
        ]
        for cycle in range(cycles)
    ]
    for one in team:
        one.cycle(0.0)
    start_s = process_time()
    for cycle, some in enumerate(events):
        for one in team:
            one.cycle(float(cycle), some)
    spent_s = process_time() - start_s
    made = sum(ended.origin != "" for one in team for ended in one.ended)
    if changes and not made:
        sys.exit("no rule has fired: nothing was measured")
    return spent_s / (agents * cycles)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--agents", type=int, default=AGENTS)
    agents: int = arguments.parse_args().agents
    one_s = cycle_s(agents, RULES, BELIEFS, CHANGES, CYCLES)
    print(f"{agents} agents, {RULES} rules, {BELIEFS} beliefs, {CHANGES} events a cycle:")
    print(f"  {one_s * 1e6:.0f} µs a cycle, {1 / one_s:.0f} agents' cycles a second")
    print("beliefs, with the same changes:")
    for beliefs in (100, 300, 1000, 3000):
        print(f"  {beliefs:5} beliefs: {cycle_s(20, RULES, beliefs, CHANGES, 100) * 1e6:.0f} µs")
    print("changes, with the same beliefs:")
    for changes in (0, 2, 4, 8, 16, 32):
        print(f"  {changes:5} events a cycle: {cycle_s(20, RULES, BELIEFS, changes, 100) * 1e6:.0f} µs")


if __name__ == "__main__":
    main()
