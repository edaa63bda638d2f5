"""Events of a packet (SRA fig. 4): conditions whose coming true is told to the service, and to the packet itself."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from robots.conditions import Condition
from robots.percepts import Percepts

TOO_FAST, TOO_FAR, TIMEOUT = "toofast", "toofar", "timeout"


@dataclass(slots=True)
class EventWatch:
    """Raises an event when all of its conditions come to hold; again only after they have not held in between."""

    events: Mapping[str, tuple[Condition, ...]]
    raised: frozenset[str] = frozenset()
    _holding: set[str] = field(default_factory=set)

    def update(self, percepts: Percepts) -> dict[str, str]:
        """The events raised at this instant, each with what was perceived, in words."""
        news: dict[str, str] = {}
        for name, conditions in self.events.items():
            verdicts = [condition.check(percepts) for condition in conditions]
            if not all(verdict.holds for verdict in verdicts):
                self._holding.discard(name)
            elif name not in self._holding:
                self._holding.add(name)
                news[name] = "; ".join(verdict.words for verdict in verdicts)
        self.raised |= news.keys()
        return news
