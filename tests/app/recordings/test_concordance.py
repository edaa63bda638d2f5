"""Instants of the wall's clock are found again on a world's."""

from datetime import UTC, datetime

import pytest

from app.recordings.concordance import Concordance
from robots.clock import ManualClock

NOON = datetime(2026, 11, 21, 12, tzinfo=UTC).timestamp()


def written(after_s: float) -> str:
    return datetime.fromtimestamp(NOON + after_s, UTC).isoformat()


def test_a_decision_is_dated_by_what_the_worlds_clock_showed_then(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = ManualClock(100.0)
    concordance = Concordance({"store": clock})
    for after_s, step_s in (
        (0.0, 6.0),
        (1.0, 0.0),
        (2.0, 6.0),
    ):  # six times as fast, and at a stand in between
        monkeypatch.setattr("time.time", lambda now=NOON + after_s: now)
        concordance.read()
        clock.advance(step_s)
    monkeypatch.setattr("time.time", lambda: NOON + 3.0)
    dated = {after_s: concordance.at_s("store", written(after_s)) for after_s in (-60, 0, 0.5, 1.5, 2.5, 9)}
    assert dated == pytest.approx({-60: 100, 0: 100, 0.5: 103, 1.5: 106, 2.5: 109, 9: 112})
