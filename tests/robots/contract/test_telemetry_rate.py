"""When a robot sends telemetry."""

import pytest

from robots.contract.telemetry_rate import UNCHANGED_EVERY_S, is_due
from robots.wire import Telemetry

SENT = Telemetry(at_s=10.0, x_m=1.0, y_m=2.0, heading_rad=0.0)


def test_the_first_is_due() -> None:
    assert is_due(SENT, None)


@pytest.mark.parametrize(
    "change", [{"x_m": 1.1}, {"holding": "sample_1"}, {"charging": True}, {"driven_by": "an operator"}]
)
def test_what_happens_is_sent_at_once(change: dict[str, object]) -> None:
    assert is_due(SENT.model_copy(update={"at_s": 10.1, **change}), SENT)


def test_while_only_counters_change_it_is_repeated_at_intervals() -> None:
    counted = {"battery": 0.5, "sensing_j": 3.0, "sensing_saved_j": 4.0}
    assert not is_due(SENT.model_copy(update={"at_s": 10.1, **counted}), SENT)
    assert is_due(SENT.model_copy(update={"at_s": 10.0 + UNCHANGED_EVERY_S, **counted}), SENT)
