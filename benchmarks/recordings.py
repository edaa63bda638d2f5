"""Costs of recordings: `python -m benchmarks.recordings [4 64 …]`, numbers of robots in the world.

Telemetry of busy robots, simulated beforehand, is recorded as the recorder does it: of one mission with four robots,
and of as many as there are robots for. Prints the size of a mission's minute on the disk, and the CPU seconds for a
minute of the world, of one mission and of all.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

from app.agents import RobotBoard
from app.recordings import RecordingStore
from app.recordings.mission_recording import MissionRecording
from benchmarks.stack import Whole
from robots.clock import ManualClock
from robots.wire import Telemetry
from robots.world import WorldFile
from robots.world.generate import generate_world, store_shape

MINUTE_S = 60
SECONDS = {4: 60, 64: 20}
TEAM = 4
WORLD = "store"

Said = Sequence[tuple[str, Telemetry]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """The costs of a minute of the world."""

    robots: int
    missions: int
    kib: float
    cpu_s: float

    def __str__(self) -> str:
        each = self.kib / self.missions
        return f"{self.robots:6d} {self.missions:8d} {each:11.0f} {self.cpu_s / self.missions:11.3f} {self.cpu_s:7.2f}"


def heard(world: WorldFile, seconds: int) -> list[Said]:
    """The telemetry of a world's robots, by tenths of a second."""
    simulation = Whole(world).simulation
    ticks = []
    for _ in range(10 * seconds):
        for _ in range(6):
            simulation.step()
        bodies = ((one.sender, one.body) for one in simulation.link.receive())
        ticks.append([(sender, body) for sender, body in bodies if isinstance(body, Telemetry)])
    return ticks


def cost(robots: Sequence[str], ticks: Sequence[Said], missions: int) -> Cost:
    board = RobotBoard(((name, WORLD) for name in robots), clocks={WORLD: ManualClock()})
    with TemporaryDirectory() as folder:
        store = RecordingStore(Path(folder), budget_bytes=10**12)
        teams = [frozenset(robots[TEAM * number : TEAM * (number + 1)]) for number in range(missions)]
        ids = [f"mission-{number}" for number in range(missions)]
        recordings = [
            MissionRecording(id_, store.new_part(id_), WORLD, robots=team)
            for id_, team in zip(ids, teams, strict=True)
        ]
        spent_s = 0.0
        for said in ticks:
            for name, telemetry in said:
                board.heard(name, telemetry)
            begun = process_time()
            views = board.views()
            for recording in recordings:
                recording.write_robots(views)
            spent_s += process_time() - begun
        for recording in recordings:
            recording.writer.close()
        size_kib = sum(one.size_bytes for one in store.recordings()) / 1024
    a_minute = MINUTE_S / (len(ticks) / 10)
    return Cost(robots=len(robots), missions=missions, kib=size_kib * a_minute, cpu_s=spent_s * a_minute)


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("robots", type=int, nargs="*", default=[4, 64])
    print("robots missions KiB/mission CPU/mission CPU/all", flush=True)
    for count in options.parse_args().robots:
        yard = max(2, count // 4)
        world = generate_world(
            store_shape(samples=4 * count, store_robots=count - yard, yard_robots=yard), seed=0
        )
        names = [spec.name for spec in world.robots]
        ticks = heard(world, SECONDS.get(count, MINUTE_S))
        for missions in sorted({1, max(1, len(names) // TEAM)}):
            print(cost(names, ticks, missions), flush=True)


if __name__ == "__main__":
    sys.exit(main())
