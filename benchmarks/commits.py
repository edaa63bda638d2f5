"""How many transactions that append an event commit a second; on PostgreSQL they commit one after the other.

    uv run python -m benchmarks.commits [SECONDS] [SERVER]

1, 2 and 4 processes write at once, each as fast as it can; SQLite, and a database on the server.
"""

import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

from app.domain.events import RobotFound
from app.store import Database
from app.store.event_log import EventLog
from app.store.migrate import migrate
from benchmarks.databases import SERVER, database_on

WRITE = "--write"
PROCESSES = (1, 2, 4)


def commits_a_second(url: str, processes: int, seconds: float) -> float:
    """Commits a second of all processes together."""
    database = Database(url)
    migrate(database)
    database.close()
    command = [sys.executable, "-m", "benchmarks.commits", WRITE, url, str(seconds)]
    with ExitStack() as running:
        writers = [
            running.enter_context(
                subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            )
            for _ in range(processes)
        ]
        for writer in writers:
            assert writer.stdout is not None
            writer.stdout.readline()
        for writer in writers:  # all are ready, so they begin together
            assert writer.stdin is not None
            writer.stdin.close()
        return sum(int(writer.stdout.read()) for writer in writers if writer.stdout) / seconds


def write(url: str, seconds: float) -> None:
    """Run as a writing process."""
    database = Database(url)
    log = EventLog(database)
    log.last()
    print("ready", flush=True)
    sys.stdin.readline()
    count, end = 0, time.monotonic() + seconds
    while time.monotonic() < end:
        with database.write() as session:
            log.append(session, RobotFound(subject=str(count), world="", actor="", comment=""))
        count += 1
    print(count, flush=True)
    database.close()


def main(seconds: float = 5.0, server: str = SERVER) -> None:
    for processes in PROCESSES:
        with tempfile.TemporaryDirectory() as folder:
            embedded = commits_a_second(f"sqlite:///{Path(folder) / 'macta.sqlite'}", processes, seconds)
        with database_on(server) as url:
            shared = commits_a_second(url, processes, seconds)
        print(
            f"{processes} processes: {embedded:.0f} a second on SQLite, {shared:.0f} on PostgreSQL",
            flush=True,
        )


if __name__ == "__main__":
    if sys.argv[1:2] == [WRITE]:
        write(sys.argv[2], float(sys.argv[3]))
    else:
        main(*(convert(given) for convert, given in zip((float, str), sys.argv[1:], strict=False)))
