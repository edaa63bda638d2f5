"""When a robot sends its telemetry."""

from robots.wire import Telemetry

TELEMETRY_S = 0.1
"""Least interval between two messages of telemetry, by the world's clock."""
COUNTERS = frozenset({"at_s", "battery", "sensing_j", "sensing_saved_j"})
"""Fields that change while nothing happens."""
STATE = tuple(name for name in Telemetry.model_fields if name not in COUNTERS)
UNCHANGED_EVERY_S = 0.5
"""Interval at which a robot repeats telemetry of which only counters change (our choice): it is to be heard."""


def is_due(new: Telemetry, sent: Telemetry | None) -> bool:
    """True if something has happened since the last telemetry sent, or that is old enough."""
    if sent is None or new.at_s - sent.at_s >= UNCHANGED_EVERY_S - 1e-6:
        return True
    return any(getattr(new, name) != getattr(sent, name) for name in STATE)
