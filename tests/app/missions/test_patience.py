"""How long robots may owe an answer: monotonic time, whatever becomes of the wall clock."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from app.store.migrate import migrate
from robots.clock import ManualClock
from tests.app.missions.mission_services import PATIENCE_S, MissionServices, services
from tests.app.sample_store import Store
from tests.app.stepped_clock import SteppedClock

STORE = Store()


class Asked:
    """A mission whose robots are asked and do not answer."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._world_clock = ManualClock()
        self.clock = SteppedClock()
        self.services = self._opened()
        migrate(self.services.database)
        self.services.start_world()
        _, self.id = self.services.plans.approve(self.services.plan(), actor="operator")
        self.services.life.monitor(self.id)
        self._world_clock.advance(10_000.0)
        self.services.life.monitor(self.id)
        assert "asking" in self.services.mission(self.id).reason

    def _opened(self) -> MissionServices:
        return services(self._folder, store=STORE, clock=self._world_clock, wall_clock=self.clock)

    def restart(self) -> None:
        """Another process goes on with it."""
        self.services.close()
        self.services = self._opened()

    def state_after(self, wait_s: float) -> str:
        self.clock.advance(wait_s)
        self.services.life.monitor(self.id)
        return self.services.mission(self.id).state


@pytest.fixture
def asked(tmp_path: Path) -> Iterator[Asked]:
    made = Asked(tmp_path)
    yield made
    made.services.close()


@pytest.mark.parametrize("back_s", [0.0, 3600.0, -3600.0])
def test_a_mission_is_unknown_when_its_robots_have_owed_an_answer_for_too_long(
    asked: Asked, back_s: float
) -> None:
    asked.clock.set_back(back_s)
    assert asked.state_after(PATIENCE_S - 1.0) == "dispatching"
    assert asked.state_after(1.0) == "unknown"


@pytest.mark.parametrize("back_s", [0.0, 3600.0, -3600.0])
def test_a_process_that_goes_on_with_it_gives_them_the_time_again(asked: Asked, back_s: float) -> None:
    asked.restart()
    asked.clock.set_back(back_s)
    assert asked.state_after(PATIENCE_S) == "dispatching"
    assert asked.state_after(PATIENCE_S) == "unknown"


def test_the_time_that_their_world_stands_at_a_breakpoint_does_not_count(asked: Asked) -> None:
    asked.services.at_breakpoint = True
    assert asked.state_after(100 * PATIENCE_S) == "dispatching"
    asked.services.at_breakpoint = False
    assert asked.state_after(PATIENCE_S - 1.0) == "dispatching"
    assert asked.state_after(1.0) == "unknown"
