"""Costs of a world's snapshot: `python -m benchmarks.snapshots 4 64`.

Busy robots, each with a script; `full`: each remembers the maximum of answers. CPU milliseconds to gather the state and
to make JSON of it, wall-clock milliseconds to write it without and with fsync; medians.
"""

import argparse
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, process_time

from benchmarks.stack import Whole
from robots.contract.mailbox import KEPT_ANSWERS
from robots.wire import Message, Performative, StatusQuery
from robots.world.generate import generate_world, store_shape
from sim.process.snapshot_file import SnapshotFile
from sim.snapshot import WorldSnapshot

SETTLE_S, TIMES = 3, 15


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """Milliseconds, and KiB."""

    robots: int
    full: bool
    gather_ms: float
    json_ms: float
    write_ms: float
    fsync_ms: float
    size_kib: float

    def __str__(self) -> str:
        return (
            f"{self.robots:6d} {'full' if self.full else 'busy':5s} {self.gather_ms:7.2f} {self.json_ms:7.2f} "
            f"{self.write_ms:7.2f} {self.fsync_ms:7.2f} {self.size_kib:8.0f}"
        )


def cost(robots: int, *, full: bool) -> Cost:
    yard = max(2, robots // 4)
    shape = store_shape(samples=4 * robots, store_robots=robots - yard, yard_robots=yard)
    world = generate_world(shape, seed=0)
    simulation = (whole := Whole(world)).simulation
    for robot in simulation.agents if full else ():
        for number in range(KEPT_ANSWERS):
            simulation.link.send(_question(robot, number))
    for _ in range(SETTLE_S):
        whole.run()
    snapshot = simulation.snapshot()
    with TemporaryDirectory() as folder, SnapshotFile(Path(folder) / "world.json") as file:
        return Cost(
            robots=robots,
            full=full,
            gather_ms=_ms(simulation.snapshot, process_time),
            json_ms=_ms(snapshot.model_dump_json, process_time),
            write_ms=_ms(lambda: _write(Path(folder) / "plain", snapshot), perf_counter),
            fsync_ms=_ms(lambda: file.write(snapshot), perf_counter),
            size_kib=os.path.getsize(Path(folder) / "world.json") / 1024,
        )


def _question(robot: str, number: int) -> Message:
    return Message(
        performative=Performative.QUERY,
        sender="service",
        receiver=robot,
        sent_at_s=0.0,
        body=StatusQuery(script_id=f"mission_{number}:{robot}"),
    )


def _write(path: Path, snapshot: WorldSnapshot) -> None:
    """Write to a new file and rename it, without fsync."""
    new = path.with_suffix(".new")
    new.write_bytes(snapshot.model_dump_json().encode())
    new.replace(path)


def _ms(work: Callable[[], object], clock: Callable[[], float]) -> float:
    took_s = []
    for _ in range(TIMES):
        begin_s = clock()
        work()
        took_s.append(clock() - begin_s)
    return 1000 * median(took_s)


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("robots", type=int, nargs="*", default=[4, 64])
    print("robots       gather    json   write   fsync      KiB")
    for robots in options.parse_args().robots:
        for full in (False, True):
            print(cost(robots, full=full), flush=True)


if __name__ == "__main__":
    main()
