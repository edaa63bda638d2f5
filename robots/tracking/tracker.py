"""The Object Tracking activity (SRA): reinforces evidence, keeps cursors, lets go of what nothing tells of any more."""

from collections.abc import Iterable, Mapping
from math import inf
from types import MappingProxyType

from robots.tracking.cursor import Cursor
from robots.tracking.observation import SIGMA_M, WEIGHT, Modality, Observation

STILL_M = 0.1
"""Something that seems to move by less than this has not moved: it is within the sensor's noise."""
GONE_S = 0.5
"""Out of view for longer than this breaks a view."""
JUMP_M = 0.5
"""What seems to be this far off was carried there, or is another's echo: it is believed anew."""
VELOCITY_GAIN = 0.1
DRIFT_M2_S = 0.01
"""How uncertain a place becomes that is not observed, variance a second."""
FORGOTTEN = 0.02
TIDY_S = 1.0


class ObjectTracking:
    """Fuses observations of any modality into one cursor a thing. Feed it once a tick."""

    def __init__(self) -> None:
        self._cursors: dict[str, Cursor] = {}
        self._tidied_s = float("-inf")

    @property
    def cursors(self) -> Mapping[str, Cursor]:
        """All things believed in, by name."""
        return MappingProxyType(self._cursors)

    def observe(self, observations: Iterable[Observation], now_s: float) -> None:
        """Account for what was told at one instant."""
        for one in observations:
            old = self._cursors.get(one.name)
            self._cursors[one.name] = _new(one, now_s) if old is None else _fused(old, one, now_s)
        if now_s - self._tidied_s >= TIDY_S:
            self._tidied_s = now_s
            self._cursors = {
                name: one for name, one in self._cursors.items() if one.evidence_at(now_s) >= FORGOTTEN
            }


def _new(one: Observation, now_s: float) -> Cursor:
    return Cursor(
        at=one.at,
        seen_s=now_s,
        viewed_s=now_s if one.modality is Modality.INFRA_RED else -inf,
        in_view_since_s=now_s,
        anchor=one.at,
        still_since_s=now_s,
        rest=one.at,
        evidence=WEIGHT[one.modality],
        variance_m2=SIGMA_M[one.modality] ** 2,
    )


def _fused(old: Cursor, one: Observation, now_s: float) -> Cursor:
    """Evidence: e + w (1 - e), of what has not decayed. Place: a Kalman filter's; velocity: a share of the surprise.

    Since when it has been in view, and still, is by infra-red alone.
    """
    step_s = now_s - old.seen_s
    evidence, weight, noise_m2 = old.evidence_at(now_s), WEIGHT[one.modality], SIGMA_M[one.modality] ** 2
    expected = old.at + old.velocity * min(step_s, GONE_S)
    variance_m2 = old.variance_m2 + DRIFT_M2_S * step_s
    gain = variance_m2 / (variance_m2 + noise_m2)
    surprise = one.at - expected
    jumped = abs(surprise) > JUMP_M
    at = one.at if jumped else expected + gain * surprise
    velocity = old.velocity + VELOCITY_GAIN * surprise / step_s if step_s > 0 else old.velocity
    left = abs(at - old.rest) > STILL_M
    viewed = one.modality is Modality.INFRA_RED
    new_view = viewed and now_s - old.viewed_s > GONE_S
    moved = viewed and abs(one.at - old.anchor) > STILL_M
    return Cursor(
        at=at,
        seen_s=now_s,
        viewed_s=now_s if viewed else old.viewed_s,
        in_view_since_s=now_s if new_view else old.in_view_since_s,
        anchor=one.at if moved else old.anchor,
        still_since_s=now_s if moved or new_view else old.still_since_s,
        velocity=0j if jumped else velocity,
        evidence=evidence + weight * (1 - evidence),
        variance_m2=noise_m2 if jumped else (1 - gain) * variance_m2,
        rest=at if left else old.rest,
        moved_s=now_s if left else old.moved_s,
    )
