"""A storm of kills: `macta serve` and everything it started is ended by SIGKILL, again and again, at any instant."""

import random
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import httpx2

from app.trials.service_process import Installation, ServiceProcess
from tests.scenarios.witness import WORLD, Witness

TOKEN = "a-token-for-the-storm"
GIVE_UP_S = 600.0


@dataclass
class Storm:
    """What is done. `environment`: settings of the service, such as another database.

    :param early: of the kills so many come before the service is ready, the others up to `latest_s` after.
    """

    data: Path
    seen: Witness
    seed: int
    kills: int
    early: int = 1
    latest_s: float = 8.0
    speed: float = 6.0
    environment: Mapping[str, str] = field(default_factory=dict)
    complaints: list[str] = field(default_factory=list)

    @property
    def installation(self) -> Installation:
        return Installation(
            data=self.data, world=WORLD, token=TOKEN, speed=self.speed, environment=self.environment
        )

    @property
    def database_url(self) -> str:
        return self.installation.database_url

    def rage(self) -> None:
        """All kills, and then a service in which everything comes to its end."""
        rng = random.Random(self.seed)
        early = set(rng.sample(range(1, self.kills), self.early))
        for number in range(self.kills):
            with self._service(number) as service:
                if number in early:
                    time.sleep(rng.uniform(0.3, 4.0))
                else:
                    service.address()
                    killer = threading.Timer(rng.uniform(0.3, self.latest_s), service.kill)
                    killer.start()
                    with suppress(httpx2.TransportError):  # it is cut off
                        self._use(service, lambda: True)
                    killer.join()
        with self._service(self.kills) as service:
            self._use(service, lambda: not self.seen.over)
            service.end()

    @contextmanager
    def _service(self, number: int) -> Iterator[ServiceProcess]:
        with self.installation.running(number) as service:
            yield service
        self.complaints.append(service.stderr)

    def _use(self, service: ServiceProcess, go_on: Callable[[], bool]) -> None:
        """State every goal, those that are accepted once more, and look on."""
        give_up = time.monotonic() + GIVE_UP_S
        with service.api() as api:
            self.seen.state_goals(api)
            while go_on():
                assert time.monotonic() < give_up, self.seen.final
                self.seen.look(api)
                time.sleep(0.1)
