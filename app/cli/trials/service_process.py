"""`macta serve` as a child process that is started, killed and restarted on one data folder."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import httpx2

from app.domain.clock import SYSTEM_CLOCK, WallClock, pause
from app.planning.pool.process import PROCESS_NAME
from app.planning.pool.process_tree import Running, kill, tree_of

READY_TIMEOUT_S = 600.0
END_TIMEOUT_S = 60.0
ANSWER_TIMEOUT_S = 20.0


class NotReady(Exception):
    """Raised when a service does not start; carries its standard error."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Installation:
    """The configuration that all processes of the service share. Their output files lie beside the data folder.

    :param world: a name or a world file.
    :param environment: settings of the service (`MACTA_…`); those of this process are not passed on.
    """

    data: Path
    world: str
    token: str
    speed: float
    environment: Mapping[str, str] = field(default_factory=dict)
    clock: WallClock = SYSTEM_CLOCK

    @property
    def database_url(self) -> str:
        return self.environment.get("MACTA_DATABASE_URL", f"sqlite:///{self.data}/macta.sqlite")

    def start(self, number: int) -> "ServiceProcess":
        """Start the service; the caller ends it."""
        command = [sys.executable, "-c", "from app.cli import main; main()", "serve", "--port", "0"]
        options = ["--data", str(self.data), "--world", self.world, "--speed", str(self.speed)]
        outside = {k: v for k, v in os.environ.items() if not k.startswith("MACTA_")}
        out, err = (self.data.parent / f"life_{number}.{where}" for where in ("out", "err"))
        with out.open("wb") as stdout, err.open("wb") as stderr:
            process = subprocess.Popen(
                [*command, *options],
                stdin=subprocess.DEVNULL,
                stdout=stdout,
                stderr=stderr,
                env={**outside, "MACTA_TOKEN": self.token, **self.environment},
            )
        return ServiceProcess(
            number=number,
            process=process,
            out=out,
            err=err,
            token=self.token,
            data=self.data,
            clock=self.clock,
        )

    @contextmanager
    def running(self, number: int) -> Iterator["ServiceProcess"]:
        """A service that ends with the block, by SIGKILL if nothing else ended it."""
        service = self.start(number)
        try:
            yield service
        finally:
            service.kill()


@dataclass(frozen=True, slots=True, kw_only=True)
class ServiceProcess:
    """One process of the service with its child processes."""

    number: int
    process: "subprocess.Popen[bytes]"
    out: Path
    err: Path
    token: str
    data: Path
    clock: WallClock

    def address(self) -> str:
        """The address of its API, once it answers.

        :raises NotReady: if it ends before that, or takes too long.
        """
        give_up_s = self.clock.monotonic_s() + READY_TIMEOUT_S
        while not (said := self.out.read_text()).endswith("\n"):
            if not self.is_alive or self.clock.monotonic_s() > give_up_s:
                raise NotReady(f"service process {self.number} did not start: {self.stderr}")
            pause(self.clock, 0.05)
        return said.partition("ready: ")[2].strip().rstrip("/")

    def api(self) -> httpx2.Client:
        """A client of its API, once it answers; the caller closes it.

        :raises NotReady: see `address`.
        """
        headers = {"authorization": f"Bearer {self.token}"}
        # It is on loopback, without TLS: certificates, which take 20 ms to read, are of no use.
        return httpx2.Client(base_url=self.address(), headers=headers, timeout=ANSWER_TIMEOUT_S, verify=False)

    @property
    def is_alive(self) -> bool:
        return self.process.poll() is None

    @property
    def stderr(self) -> str:
        """Its standard error."""
        return self.err.read_text()

    @property
    def memory_mb(self) -> float:
        """Memory of its own process, without the simulation and the planning processes."""
        return tree_of(self.process.pid)[0].memory_mb if self.is_alive else 0.0

    def kill(self) -> None:
        """Send SIGKILL to it and all its descendants."""
        kill(tree_of(self.process.pid))
        self.process.wait()

    def end(self) -> None:
        """Terminate it as an operator would.

        :raises subprocess.TimeoutExpired: if it does not end.
        """
        self.process.send_signal(signal.SIGTERM)
        self.process.wait(timeout=END_TIMEOUT_S)

    def simulation(self) -> Running | None:
        """The simulation's process; None if there is none."""
        return holder_of(self.data / "worlds", tree_of(self.process.pid))

    def planners(self) -> list[Running]:
        """Its planning processes."""
        return [one for one in tree_of(self.process.pid) if one.name == PROCESS_NAME]


def holder_of(folder: Path, tree: list[Running]) -> Running | None:
    """The process that has the lock file of a world in the folder open, which is the one that simulates it."""
    return next((one for one in tree if any(_is_lock(opened, folder) for opened in _opened(one))), None)


def _is_lock(opened: Path, folder: Path) -> bool:
    return opened.suffix == ".lock" and opened.parent == folder.resolve()


def _opened(process: Running) -> Iterator[Path]:
    try:
        names = os.listdir(f"/proc/{process.pid}/fd")
    except OSError:  # the process has ended
        return
    for name in names:
        try:
            yield Path(os.readlink(f"/proc/{process.pid}/fd/{name}"))
        except OSError:
            continue
