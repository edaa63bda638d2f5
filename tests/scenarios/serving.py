"""`macta serve` as a process of its own, as an operator starts it."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx2

START_S = 600.0
END_S = 60.0

Process = subprocess.Popen[str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Served:
    """A running service: its address, its token and its process."""

    address: str
    token: str
    process: Process

    @property
    def console(self) -> str:
        return f"{self.address}/?token={self.token}"

    def client(self) -> httpx2.Client:
        """An operator's."""
        headers = {"authorization": f"Bearer {self.token}"}
        return httpx2.Client(base_url=self.address, headers=headers, timeout=20, verify=False)  # no TLS


@contextmanager
def macta_serve(data: Path, *options: str, **variables: str) -> Iterator[Served]:
    """Run `macta serve` on a free port for the length of the block, and end it as an operator would.

    :param variables: of its environment, without `MACTA_`.
    """
    given = ("serve", "--port", "0", "--data", str(data), *options)
    with _macta(*given, **variables) as process:
        found = _said(process, r"Macta is ready: (http://\S+)/(?:\?token=(\S+))?")
        assert (found[2] is None) == ("token" in variables), "only a token that was made is printed"
        yield Served(address=found[1], token=found[2] or variables["token"], process=process)


@contextmanager
def macta_fleet(data: Path, *options: str, **variables: str) -> Iterator[Process]:
    """Run `macta fleet` for the length of the block."""
    with _macta("fleet", "--data", str(data), *options, **variables) as process:
        _said(process, r"The fleet of \w+ is ready: .*")
        yield process


@contextmanager
def _macta(*arguments: str, **variables: str) -> Iterator[Process]:
    """A command as a process of its own. By SIGTERM after the block it must end in order, if nothing else ended it."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("MACTA_")}
    environment |= {f"MACTA_{name.upper()}": value for name, value in variables.items()}
    process = command(arguments, environment)
    try:
        yield process
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
            assert process.wait(timeout=END_S) == 0
            _, complaints = process.communicate()
            assert "Traceback" not in complaints, complaints
    finally:
        process.kill()
        process.wait()
        for stream in (process.stdout, process.stderr):
            assert stream is not None
            stream.close()


def command(arguments: Sequence[str], environment: Mapping[str, str]) -> subprocess.Popen[str]:
    """A `macta` command as it is started from a shell."""
    return subprocess.Popen(
        [sys.executable, "-c", "from app.cli import main; main()", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
    )


def _said(process: Process, expected: str) -> re.Match[str]:
    """What the process says once it is ready."""
    assert process.stdout is not None
    late = threading.Timer(START_S, process.kill)
    late.start()
    begun = time.monotonic()
    line = process.stdout.readline()
    late.cancel()
    found = re.fullmatch(expected + r"\n", line)
    if found is None:
        process.kill()
        _, complaints = process.communicate()
        raise AssertionError(f"not ready after {time.monotonic() - begun:.0f} s: {line!r} {complaints}")
    return found
