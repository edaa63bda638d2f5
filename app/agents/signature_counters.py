"""Keeps the counters of robots' signed messages in the database, so that a restart does not take recorded ones."""

from collections.abc import Mapping

from sqlalchemy import select

from app.domain.clock import SYSTEM_CLOCK, WallClock
from app.store import Database, SignatureCounterRow
from robots.link.mqtt.signature import Accepted

SAVE_INTERVAL_S = 5.0
"""Wall-clock seconds between two writes of a world's counters: what came later may be sent once more after a crash."""


class SignatureCounters:
    """Of all worlds. A world that is removed leaves its counters: it may be added again under the same name."""

    def __init__(self, database: Database, *, wall: WallClock = SYSTEM_CLOCK) -> None:
        self._database = database
        self._wall = wall
        self._saved: dict[str, Mapping[str, Accepted]] = {}
        self._saved_s: dict[str, float] = {}

    def load(self, world: str) -> Mapping[str, Accepted]:
        """By topic, what was accepted last before the restart."""
        query = select(SignatureCounterRow).where(SignatureCounterRow.world == world)
        with self._database.read() as session:
            return {
                row.topic: Accepted(
                    key_id=row.key_id, before=int(row.before), last=int(row.last), signature=row.signature
                )
                for row in session.scalars(query)
            }

    def save(self, world: str, accepted: Mapping[str, Accepted]) -> None:
        """Record what has changed, at most every `SAVE_INTERVAL_S`; called often."""
        now_s = self._wall.monotonic_s()
        if now_s - self._saved_s.get(world, float("-inf")) < SAVE_INTERVAL_S:
            return
        self._saved_s[world] = now_s
        before = self._saved.get(world, {})
        changed = {topic: one for topic, one in accepted.items() if before.get(topic) != one}
        if not changed:
            return
        with self._database.write() as session:
            for topic, one in changed.items():
                session.merge(
                    SignatureCounterRow(
                        topic=topic,
                        world=world,
                        key_id=one.key_id,
                        before=str(one.before),
                        last=str(one.last),
                        signature=one.signature,
                    )
                )
        self._saved[world] = accepted
