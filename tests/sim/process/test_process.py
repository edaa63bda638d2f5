"""The process of a world. These few tests wait on the wall clock, for pacing and ending are about it."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from robots.wire import Message, Performative, Receipt, Telemetry
from sim import SimulationError, SimulationProcess
from tests.sim.rig import two_rooms
from tests.waiting import until

REPOSITORY = Path(__file__).parents[2]


def gone(pid: int) -> bool:
    """True when the process is ended and collected, or only a dead entry is left."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True


@pytest.fixture
def process() -> Iterator[SimulationProcess]:
    with SimulationProcess.start(two_rooms(samples={"rock": "corner"}), seed=1, speed=20.0) as started:
        yield started


def test_a_world_runs_pauses_and_goes_on(process: SimulationProcess) -> None:
    until(lambda: process.now_s() > 0.5)
    process.pause()
    stood_s = process.now_s()
    time.sleep(0.2)
    assert process.now_s() == stood_s
    process.pause(False)
    until(lambda: process.now_s() > stood_s + 0.5)


def test_the_clock_follows_the_speed(process: SimulationProcess) -> None:
    process.set_speed(2.0)
    from_s, wall_s = process.now_s(), time.monotonic()
    time.sleep(1.0)
    pace = (process.now_s() - from_s) / (time.monotonic() - wall_s)
    assert pace == pytest.approx(2.0, rel=0.25)


def test_flat_out_is_faster_than_real_time(process: SimulationProcess) -> None:
    process.set_speed(None)
    until(lambda: process.real_time_factor > 2)


def test_the_truth_comes_over_the_control_channel(process: SimulationProcess) -> None:
    truth = process.truth()
    assert truth.samples["rock"].place == "corner"
    assert set(truth.robots) == {"fred"}


def test_a_speed_of_nothing_is_refused_with_a_reason(process: SimulationProcess) -> None:
    with pytest.raises(SimulationError, match="pause it"):
        process.set_speed(0.0)
    assert process.alive


def test_telemetry_comes_over_the_link_thinned_to_the_wall_clock(process: SimulationProcess) -> None:
    process.set_speed(None)
    wall_s = time.monotonic()
    arrived = []
    while time.monotonic() < wall_s + 1.0:
        arrived += process.link.receive(0.1)
    told = [message for message in arrived if isinstance(message.body, Telemetry)]
    assert 5 <= len(told) <= 25
    assert told[-1].sent_at_s - told[0].sent_at_s > 2


def test_stopping_ends_the_process_and_may_be_repeated(process: SimulationProcess) -> None:
    pid = process.pid
    assert pid is not None
    process.stop()
    process.stop()
    assert not process.alive
    assert gone(pid)
    assert not Path(f"/proc/{pid}").exists()
    with pytest.raises(SimulationError, match="gone"):
        process.truth()


def test_ctrl_c_does_not_end_the_world(process: SimulationProcess) -> None:
    assert process.pid is not None
    os.kill(process.pid, signal.SIGINT)
    from_s = process.now_s()
    until(lambda: process.now_s() > from_s + 0.5)
    assert process.alive


def test_a_paused_world_still_takes_what_the_service_sends(process: SimulationProcess) -> None:
    process.pause()
    sender = threading.Thread(target=send_many, args=(process, 5000), daemon=True)
    sender.start()
    sender.join(timeout=20)
    assert not sender.is_alive()


def send_many(process: SimulationProcess, count: int) -> None:
    for _ in range(count):
        process.link.send(
            Message(
                performative=Performative.CONFIRM,
                sender="service",
                receiver="fred",
                sent_at_s=0,
                body=Receipt(),
            )
        )


def test_a_killed_world_is_an_error_and_not_a_hang(process: SimulationProcess) -> None:
    assert process.pid is not None
    os.kill(process.pid, signal.SIGKILL)
    with pytest.raises(SimulationError, match="gone"):
        process.truth()


PARENT = """
import time
from robots.world import load_world
from sim import SimulationProcess

if __name__ == "__main__":
    process = SimulationProcess.start(load_world("sample_store"), speed=None)
    print(process.pid, flush=True)
    time.sleep(60)
"""


def test_a_world_dies_with_a_parent_that_is_killed(tmp_path: Path) -> None:
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    parent = subprocess.Popen(
        [sys.executable, str(script)],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
    )
    try:
        assert parent.stdout is not None
        child = int(parent.stdout.readline())
        assert not gone(child)
        parent.kill()
        parent.wait()
        until(lambda: gone(child))
    finally:
        parent.kill()
        parent.wait()
        if parent.stdout is not None:
            parent.stdout.close()
