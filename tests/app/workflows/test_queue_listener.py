"""How often a queue is looked at for workflows that nobody told of."""

import pytest

from app.workflows.queue_listener import ASLEEP_S, AWAKE_S, _Pause
from robots.clock import ManualClock


@pytest.mark.parametrize(("busy", "looks"), [(True, 20), (False, 2)])
def test_a_queue_is_looked_at_seldom_once_nothing_was_in_it_for_a_while(
    busy: bool, looks: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = ManualClock()
    monkeypatch.setattr("app.workflows.queue_listener.time.monotonic", clock.now_s)
    pause = _Pause(lambda: True, is_busy=lambda: busy)
    waited: list[float] = []

    def wait(timeout: float) -> bool:
        waited.append(timeout)
        clock.advance(timeout)
        return False

    monkeypatch.setattr(pause._over, "wait", wait)
    while clock.now_s() < AWAKE_S:
        pause.wait(0.1)
    awake = len(waited)
    assert awake == pytest.approx(AWAKE_S / 0.1, abs=1)
    while clock.now_s() < AWAKE_S + 2.0 * ASLEEP_S:
        pause.wait(0.1)
    assert len(waited) - awake == pytest.approx(looks, abs=1)
    monkeypatch.setattr(pause._over, "wait", lambda _: True)  # there is something
    pause.wait(0.1)
    monkeypatch.setattr(pause._over, "wait", wait)
    pause.wait(0.1)
    assert waited[-1] == 0.1
