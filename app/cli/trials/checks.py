"""Checks of the record against the world: each returns the disagreements in words, none if there are none."""

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from sqlalchemy import select

from app.cli.trials.observer import ENDED
from app.store import Database, EventRow, MessageRow, ScriptRow
from robots.wire import SymbolicFact

IsTrue = Callable[[SymbolicFact], bool | None]
"""None: the ground truth cannot tell."""
Goal = Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedReports:
    """The robots' recorded reports, oldest first by their own clocks; scripts; the numbers of all stored events."""

    reports: Sequence[Mapping[str, Any]]
    scripts: Sequence[ScriptRow]
    events: Sequence[int]

    @classmethod
    def read(cls, database_url: str) -> "RecordedReports":
        """Read from the database."""
        database = Database(database_url)
        try:
            with database.read() as session:
                bodies = [row.body["body"] for row in session.scalars(select(MessageRow))]
                return cls(
                    reports=sorted(filter(_is_transition, bodies), key=lambda body: body["at_s"]),
                    scripts=session.scalars(select(ScriptRow)).all(),
                    events=session.scalars(select(EventRow.seq).order_by(EventRow.seq)).all(),
                )
        finally:
            database.close()

    def executed(self) -> Mapping[tuple[str, str, str], int]:
        """How often each packet's start and end, and each script's end, was reported: by script, packet and state.

        A packet that continues after a pause does not start again.
        """
        counts: Counter[tuple[str, str, str]] = Counter()
        paused: set[tuple[str, str]] = set()
        for body in self.reports:
            script, packet, state = _event(body)
            if state == "paused":
                paused.add((script, packet))
            elif state != "running" or (script, packet) not in paused:
                counts[script, packet, state] += 1
            else:
                paused.remove((script, packet))
        return counts

    def clashes(self) -> Sequence[tuple[str, str]]:
        """Pairs of scripts of one robot that overlap: the second started before the first had ended."""
        spans: dict[str, tuple[float, float]] = {}
        for body in self.reports:
            if body["kind"] != "packet_report":
                continue
            began_s, _ = spans.get(body["script_id"], (body["at_s"], 0.0))
            spans[body["script_id"]] = (began_s, body["at_s"])
        robots: dict[str, list[tuple[float, float, str]]] = {}
        for script in self.scripts:
            if script.id in spans:
                robots.setdefault(script.robot, []).append((*spans[script.id], script.id))
        pairs = [pair for known in robots.values() for pair in pairwise(sorted(known))]
        return [(one[2], other[2]) for one, other in pairs if other[0] < one[1]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Beliefs:
    """The service's beliefs: facts as (predicate, arguments), and samples of unknown place."""

    facts: Collection[tuple[str, tuple[str, ...]]]
    unknown: Collection[str] = field(default=())


def unfinished_goals(goals: Iterable[Goal]) -> list[str]:
    """Goals that have not ended, or ended without an outcome."""
    known = list(goals)
    still = [goal for goal in known if goal["state"] not in ENDED]
    unsaid = [goal for goal in known if goal["state"] in ENDED and not goal["outcome"]]
    return [
        *(f"{goal['id']} did not end: {goal['state']}, {goal['reason']}" for goal in still),
        *(f"{goal['id']} is {goal['state']} without an outcome" for goal in unsaid),
    ]


def untrue_goals(goals: Iterable[Goal], is_true: IsTrue) -> list[str]:
    """Goals recorded as completed that are not true in the world."""
    completed = [goal for goal in goals if goal["outcome"] == "completed"]
    return [
        f"{goal['id']} ({goal['text']}) was completed, but {fact} is not true"
        for goal in completed
        for fact in map(SymbolicFact.model_validate, goal["goal"])
        if is_true(fact) is False
    ]


def disagreements(found: Beliefs, lies: Mapping[str, str | None], known_as: Mapping[str, str]) -> list[str]:
    """Samples that are not where they are believed to be.

    :param lies: by sample, the true place or gripper it is in; None on the bare floor.
    :param known_as: by berth, its location; a sample may be believed to be in either.
    """
    wrong = []
    for sample, ref in lies.items():
        believed = [args[1] for name, args in found.facts if name == "in" and args[0] == sample]
        if sample in found.unknown and not believed:
            continue
        allowed = {ref, known_as.get(ref or "", ref)}
        if len(believed) != 1 or believed[0] not in allowed:
            wrong.append(f"{sample} is in {ref or 'no place'}, and believed in {believed or 'no place'}")
    return wrong


def executed_twice(record: RecordedReports) -> list[str]:
    """Packets that robots executed more than once, and scripts that overlap on one robot."""
    twice = [
        f"{packet} of {script} was {state} {count} times"
        for (script, packet, state), count in record.executed().items()
        if count > 1
    ]
    return [*twice, *(f"{one} and {other} ran on one robot at once" for one, other in record.clashes())]


def lost_events(seen: Sequence[int], kept: Sequence[int]) -> list[str]:
    """Deviations of a resumed event stream from every event once, in order.

    :param seen: the numbers in the order of arrival.
    :param kept: the stored numbers, in order.
    """
    if list(seen) == list(kept):
        return []
    missing = sorted(set(kept) - set(seen))
    doubled = len(seen) - len(set(seen))
    return [
        f"the event stream had {len(seen)} of {len(kept)}: not {missing[:5]}, {doubled} twice, "
        f"{'in' if list(seen) == sorted(seen) else 'out of'} order"
    ]


def _is_transition(body: Mapping[str, Any]) -> bool:
    """True for a packet that starts, pauses or ends, and for a script that ends."""
    if body["kind"] not in ("packet_report", "script_report"):
        return False
    of_packet = body["kind"] == "packet_report"
    begins = of_packet and (
        body["state"] == "paused"
        or (body["state"] == "running" and not body["detail"] and not body["events"])
    )
    return begins or body["state"] in ("finished", "failed", "cancelled")


def _event(body: Mapping[str, Any]) -> tuple[str, str, str]:
    packet = body["packet_id"] if body["kind"] == "packet_report" else "the script"
    return (body["script_id"], packet, body["state"])
