"""What a robot knows of its task, as beliefs that last as long as it is so."""

from collections.abc import Container, Mapping
from dataclasses import dataclass, field

from robots.deliberative.terms import Term
from robots.deliberative.vocabulary import DOING, GIVEN, HAS_SCRIPT, LAST_SEEN
from robots.executive.packet_run import MISSING
from robots.perception.percepts import SIGHT, Percepts
from robots.reactive.stall import MET, MISSED, STUCK

CHARGING = "charging"
"""The agent that takes the place of the robot's own upkeep."""
TAKES_OVER: Mapping[str, str] = {
    "unstuck": STUCK,
    "give_way": MET,
    "regrip": MISSED,
    "search": MISSING,
}
"""By agent, the event of a packet on which it acts in place of the packet's own retries and limits."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """The packet of the service's script that is under way, waiting or running, and its arguments."""

    tag: str
    arguments: Mapping[str, str] = field(default_factory=dict)


def taken_over(agents: Container[str]) -> frozenset[str]:
    """The events of packets that are left to agents of these names."""
    return frozenset(event for name, event in TAKES_OVER.items() if name in agents)


def known_of(task: Task | None, percepts: Percepts | None) -> frozenset[Term]:
    """The beliefs on the task, and on what it names and is out of view."""
    if task is None:
        return frozenset()
    known = [Term(HAS_SCRIPT), Term(DOING, (task.tag,))]
    known += [Term(GIVEN, one) for one in task.arguments.items()]
    if percepts is not None and percepts.data.holds(SIGHT):
        for name in task.arguments.values():
            last = percepts.last_seen.get(name)
            if last is not None and not percepts.sees(name):
                known.append(Term(LAST_SEEN, (name, round(last.at.real, 1), round(last.at.imag, 1))))
    return frozenset(known)
