"""Kill -9 anywhere: nothing is lost, nothing is done twice, and the record says what is true.

`macta soak` does so for as long as wanted; `test_going_on.py` draws instants from a mission with a given plan.
"""

import random
import signal
import threading
import time
from contextlib import suppress
from pathlib import Path

import httpx2

from tests.scenarios.judge import judge
from tests.scenarios.killing import kill_family
from tests.scenarios.serving import Served, macta_serve
from tests.scenarios.witness import Witness

GOALS = {"one": "move sample_1 to bay_7", "two": "move sample_4 to door_2"}
LATEST_S = 4.0
"""At most so long after the service is ready it is killed."""
SPEED = ("--speed", "12")
GIVE_UP_S = 1000.0
"""Of the world's time: on a busy machine it goes slower, as all else does. The two missions take some 250 s."""


def used_until_it_is_killed(seen: Witness, service: Served, after_s: float) -> None:
    """State every goal and look on; the service and all it started is ended by SIGKILL meanwhile."""
    killer = threading.Timer(after_s, kill_family, [service.process.pid])
    killer.start()
    with suppress(httpx2.TransportError), service.client() as api:  # it is cut off
        seen.state_goals(api)
        while True:
            seen.look(api)
            time.sleep(0.05)
    killer.join()
    service.process.wait()


def used_until_all_is_over(seen: Witness, service: Served) -> None:
    """State every goal, those that are accepted once more, and look on."""
    before_s = seen.observer.time_s
    with service.client() as api:
        seen.state_goals(api)
        while not seen.over:
            assert seen.observer.time_s < before_s + GIVE_UP_S, seen.final
            seen.look(api)
            time.sleep(0.05)


def test_a_kill_of_everything_loses_nothing_and_does_nothing_twice(tmp_path: Path) -> None:
    data, rng = tmp_path / "data", random.Random(5)
    seen = Witness(GOALS, by_hand=frozenset({"two"}))
    with macta_serve(data, *SPEED) as service:
        used_until_it_is_killed(seen, service, rng.uniform(0.3, LATEST_S))
    with macta_serve(data, *SPEED) as service:
        used_until_all_is_over(seen, service)
        service.process.send_signal(signal.SIGTERM)
        _, complaints = service.process.communicate()
    judge(seen, data=data, database_url=f"sqlite:///{data}/macta.sqlite")
    assert "starts a new run" not in complaints
    assert [goal["outcome"] for goal in seen.final] == ["completed"] * len(GOALS), seen.final
