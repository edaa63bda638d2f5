"""Debian's Mosquitto as a process of the test's own: on a free port, configured by the test, to be killed at will."""

import getpass
import shutil
import signal
import socket
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from tests.ports import free_port
from tests.waiting import until

BINARY = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin")
START_S = 20.0
ACL = Path(__file__).parent.parent / "examples" / "mosquitto.acl"

needs_mosquitto = pytest.mark.skipif(BINARY is None, reason="no mosquitto: apt-get install mosquitto")


@dataclass
class Mosquitto:
    """A broker that can be killed and started again on the same port."""

    folder: Path
    port: int
    lines: Sequence[str] = ()
    _process: subprocess.Popen[bytes] | None = field(default=None, init=False)

    @property
    def url(self) -> str:
        return f"mqtt://127.0.0.1:{self.port}"

    def start(self) -> None:
        assert BINARY is not None
        config = self.folder / "mosquitto.conf"
        lines = self.lines or ("allow_anonymous true",)
        # NOTE: started as root it would become a user who cannot read the test's files.
        own = [f"user {getpass.getuser()}", f"listener {self.port} 127.0.0.1"]
        config.write_text("\n".join([*own, *lines]) + "\n")
        with (self.folder / "mosquitto.log").open("ab") as log:
            self._process = subprocess.Popen([BINARY, "-c", str(config)], stdout=log, stderr=log)
        until(self._listens, f"no broker: see {self.folder / 'mosquitto.log'}", START_S)

    def kill(self) -> None:
        """As a power failure would."""
        assert self._process is not None
        self._process.kill()
        self._process.wait()

    def pause(self, paused: bool = True) -> None:
        """Let it hang, or go on."""
        self.signal(signal.SIGSTOP if paused else signal.SIGCONT)

    def signal(self, number: signal.Signals) -> None:
        """SIGHUP: have it read its files again."""
        assert self._process is not None
        self._process.send_signal(number)

    def _listens(self) -> bool:
        assert self._process is not None
        assert self._process.poll() is None, (self.folder / "mosquitto.log").read_text()
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0


@contextmanager
def mosquitto(folder: Path, *lines: str) -> Iterator[Mosquitto]:
    """A broker for the length of the block.

    :param lines: of its configuration, after the listener; without any, everybody is let in.
    """
    folder.mkdir(parents=True, exist_ok=True)
    broker = Mosquitto(folder, free_port(), lines)
    broker.start()
    try:
        yield broker
    finally:
        broker.kill()
