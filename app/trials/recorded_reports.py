"""What the record itself says of what robots did and what happened, read beside the service."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from sqlalchemy import select

from app.database import Database, EventRow, MessageRow, ScriptRow


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """What robots were recorded to have said, oldest first by their own clock; the scripts it was about; the numbers of
    all events that are kept, in order.
    """

    told: Sequence[Mapping[str, Any]]
    scripts: Sequence[ScriptRow]
    events: Sequence[int]

    @classmethod
    def read(cls, database_url: str) -> "Record":
        """As it is now."""
        database = Database(database_url)
        try:
            with database.read() as session:
                bodies = [row.body["body"] for row in session.scalars(select(MessageRow))]
                return cls(
                    told=sorted(filter(_tells, bodies), key=lambda body: body["at_s"]),
                    scripts=session.scalars(select(ScriptRow)).all(),
                    events=session.scalars(select(EventRow.seq).order_by(EventRow.seq)).all(),
                )
        finally:
            database.close()

    def executed(self) -> Mapping[tuple[str, str, str], int]:
        """How often each packet's begin and end, and each script's end, was told: by script, packet and state.

        A packet that goes on after a pause does not begin again.
        """
        counts: Counter[tuple[str, str, str]] = Counter()
        paused: set[tuple[str, str]] = set()
        for body in self.told:
            script, packet, state = _event(body)
            if state == "paused":
                paused.add((script, packet))
            elif state != "running" or (script, packet) not in paused:
                counts[script, packet, state] += 1
            else:
                paused.remove((script, packet))
        return counts

    def clashes(self) -> Sequence[tuple[str, str]]:
        """Scripts of one robot of which a packet of the second began before the last of the first had ended."""
        spans: dict[str, tuple[float, float]] = {}
        for body in self.told:
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


def _tells(body: Mapping[str, Any]) -> bool:
    """A packet that begins, pauses or ends, or a script that ends; not what else is said while one runs."""
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
