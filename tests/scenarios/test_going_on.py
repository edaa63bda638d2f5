"""Kill -9 of a service and all it started, or of its world alone, in the middle of a mission: it goes on as if nothing
had been. The plan is given; the instants are drawn by a seed, in the world's time.
"""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from app.cli.trials.checks import RecordedReports, executed_twice
from tests.scenarios.judge import snapshot_truth
from tests.scenarios.killing import kill_family

KILLS = 3
GIVE_UP_S = 200.0
"""Of a life; a busy machine takes more than twice the world's time for it."""
MOST_S = 12.0
"""The mission takes some 50 s of the world's time."""


class Lives:
    """One process after the other on one data folder, and every line that they said."""

    def __init__(self, folder: Path) -> None:
        self._data = folder / "data"
        self.said: list[dict[str, Any]] = []
        self.complaints = ""

    def live(self, *, world_s: float, world_alone: bool = False) -> None:
        """A life that is ended when its world's time has gone on by so much, or when all is done.

        :param world_alone: the world's process is killed first, half-way.
        """
        process = self._start()
        began, killed, give_up = None, None, time.monotonic() + GIVE_UP_S
        assert process.stdout is not None
        is_late = False
        for line in process.stdout:
            self.said.append(now := json.loads(line))
            began = now["time_s"] if began is None else began
            if world_alone and now["time_s"] - began >= world_s / 2:
                os.kill(now["world"], signal.SIGKILL)
                killed, world_alone = now["world"], False
            is_late = time.monotonic() >= give_up
            if is_late or (now["time_s"] - began >= world_s and now["world"] != killed):
                kill_family(process.pid)
                break
        self._end(process)
        assert not is_late, self.complaints

    def die_early(self, wall_s: float) -> None:
        """A life that is ended while it begins."""
        process = self._start()
        time.sleep(wall_s)
        kill_family(process.pid)
        self._end(process)

    def _start(self) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "tests.scenarios.scripted_service", str(self._data)]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def _end(self, process: subprocess.Popen[str]) -> None:
        _, complaints = process.communicate()
        self.complaints += complaints


@pytest.mark.timeout(900)
def test_a_mission_survives_kills_at_any_instant(tmp_path: Path) -> None:
    rng, lives, data = random.Random(7), Lives(tmp_path), tmp_path / "data"
    for life in range(KILLS):
        lives.live(world_s=rng.uniform(0.2, MOST_S), world_alone=life == KILLS // 2)
        lives.die_early(rng.uniform(0.1, 2.0))
    lives.live(world_s=1000.0)
    last = lives.said[-1]
    assert last["outcome"] == "completed", (last, lives.complaints)
    assert {one["goal"] for one in lives.said} == {last["goal"]}
    assert snapshot_truth(data).samples["sample_1"].ref == "bay_7"
    assert not executed_twice(RecordedReports.read(f"sqlite:///{data}/macta.sqlite"))
    times_s = [one["time_s"] for one in lives.said]
    assert times_s == sorted(times_s)
    assert len({one["world"] for one in lives.said}) == KILLS + 2
