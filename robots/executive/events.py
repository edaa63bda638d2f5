"""Events of a packet (SRA fig. 4): reported to the service, and readable by the packet's own conditions."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from robots.conditions.verdict import Condition
from robots.perception.percepts import Percepts

FLICKER_S = 0.5
"""An interruption shorter than this is sensor noise: the event is not raised again."""


@dataclass(slots=True)
class EventWatch:
    """Raises an event when all of its conditions start to hold."""

    events: Mapping[str, tuple[Condition, ...]]
    raised: frozenset[str] = frozenset()
    held_s: dict[str, float] = field(default_factory=dict)
    """When the conditions of each event last held, in the packet's time."""

    def update(self, percepts: Percepts) -> dict[str, str]:
        """The events raised in this tick, each with what was perceived, in words."""
        news: dict[str, str] = {}
        for name, conditions in self.events.items():
            verdicts = [condition.check(percepts) for condition in conditions]
            if False in [verdict.holds for verdict in verdicts]:
                continue
            now_s = percepts.progress.elapsed_s
            if now_s - self.held_s.get(name, -FLICKER_S) >= FLICKER_S:
                news[name] = "; ".join(verdict.words for verdict in verdicts)
            self.held_s[name] = now_s
        if news:
            self.raised = self.raised.union(news)
        return news
