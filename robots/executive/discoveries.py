"""Samples that a robot sees lie in places and that its map does not have: each is reported once."""

from robots.conditions.facts import lying_still
from robots.perception.percepts import LOCATING, Percepts
from robots.physical.profile import RobotProfile
from robots.wire import SampleReport


class Discoveries:
    """Notes which unknown samples were reported, and where. Lost at a restart: a report twice does no harm."""

    def __init__(self, profile: RobotProfile) -> None:
        self._known = profile.samples
        self._reported: dict[str, str] = {}

    def new(self, percepts: Percepts | None) -> tuple[SampleReport, ...]:
        """The reports of unknown samples that lie still in places, since the last call."""
        if percepts is None or self._known is None or not percepts.data.holds(LOCATING):
            return ()
        unknown = [tag for tag in percepts.tags if tag not in self._known]
        found = [(tag, place) for tag in unknown if (place := lying_still(percepts, tag)) is not None]
        news = [(tag, place) for tag, place in found if self._reported.get(tag) != place]
        self._reported.update(news)
        return tuple(SampleReport(sample=tag, place=place, at_s=percepts.time_s) for tag, place in news)
