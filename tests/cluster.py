"""A PostgreSQL server of a test's own, that may be killed."""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.ports import free_port


@dataclass(frozen=True, slots=True, kw_only=True)
class Cluster:
    """A server: its programs, its folder and its port on loopback."""

    programs: Path
    folder: Path
    port: int

    @property
    def url(self) -> str:
        return f"postgresql+psycopg://postgres@127.0.0.1:{self.port}/postgres"

    def start(self) -> None:
        options = f"-h 127.0.0.1 -p {self.port} -k {self.folder}"
        log = str(self.folder / "log")
        self._control("start", "--wait", "--silent", "--log", log, "--options", options)

    def kill(self) -> None:
        """As if the machine had lost its power: no connection is ended in order, nothing is written down."""
        self._control("stop", "--mode", "immediate")

    def _control(self, *arguments: str) -> None:
        run([str(self.programs / "pg_ctl"), "--pgdata", str(self.folder / "data"), *arguments])


def run(command: Sequence[str]) -> None:
    """Run it as the user postgres: no server runs as root."""
    as_root = os.geteuid() == 0
    changed = ["setpriv", "--reuid=postgres", "--regid=postgres", "--init-groups"] if as_root else []
    subprocess.run(
        [*changed, *command], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=60
    )


@contextmanager
def own_cluster() -> Iterator[Cluster]:
    """A fresh server for the length of the block; the test is skipped where PostgreSQL is not installed."""
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin"))
    if not found:
        pytest.skip("PostgreSQL is not installed in /usr/lib/postgresql")
    folder = Path(tempfile.mkdtemp(prefix="macta-cluster-"))
    if os.geteuid() == 0:
        shutil.chown(folder, "postgres", "postgres")
    cluster = Cluster(programs=found[-1], folder=folder, port=free_port())
    trust = ["--auth", "trust", "--username", "postgres", "--no-sync"]
    try:
        run([str(cluster.programs / "initdb"), "--pgdata", str(folder / "data"), *trust])
        cluster.start()
        yield cluster
        cluster.kill()
    finally:
        shutil.rmtree(folder, ignore_errors=True)
