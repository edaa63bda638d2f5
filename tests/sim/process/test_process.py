"""The process of a world. The loop inside it is tested with a manual clock in `test_world_loop`."""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from robots.wire import Message, Performative, Receipt, Telemetry
from sim import SimulationError, SimulationProcess
from sim.process import world_loop
from tests.sim.rig import two_rooms
from tests.waiting import LONG_S, until

REPOSITORY = Path(__file__).parents[3]


def gone(pid: int) -> bool:
    """True when the process is ended and collected, or only a dead entry is left."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True


@pytest.fixture(scope="module")
def shared() -> Iterator[SimulationProcess]:
    """One process for the tests that leave it running."""
    with SimulationProcess.start(two_rooms(samples={"rock": "corner"}), seed=1, speed=20.0) as started:
        yield started


def test_a_world_runs_pauses_and_goes_on(shared: SimulationProcess) -> None:
    until(lambda: shared.now_s() > 0.5)
    shared.pause()
    stood_s = shared.now_s()
    assert shared.truth().time_s == stood_s
    shared.pause(False)
    until(lambda: shared.now_s() > stood_s + 0.5)


def test_the_truth_comes_over_the_control_channel(shared: SimulationProcess) -> None:
    truth = shared.truth()
    assert truth.samples["rock"].place == "corner"
    assert set(truth.robots) == {"fred"}


def test_telemetry_comes_over_the_link(shared: SimulationProcess) -> None:
    until(lambda: any(isinstance(one.body, Telemetry) for one in shared.link.receive(0.1)))


def test_a_late_answer_is_not_taken_for_the_next_commands(
    shared: SimulationProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert shared.pid is not None
    os.kill(shared.pid, signal.SIGSTOP)
    with monkeypatch.context() as impatient:
        impatient.setattr("sim.process.process.ANSWER_TIMEOUT_S", 0.1)
        with pytest.raises(SimulationError, match="did not answer"):
            shared.pause(False)
    os.kill(shared.pid, signal.SIGCONT)
    assert set(shared.truth().robots) == {"fred"}


def test_ctrl_c_does_not_end_the_world(shared: SimulationProcess) -> None:
    assert shared.pid is not None
    os.kill(shared.pid, signal.SIGINT)
    from_s = shared.now_s()
    until(lambda: shared.now_s() > from_s + 0.5)
    assert shared.alive


def test_what_tells_all_processes_to_end_leaves_the_worlds_end_to_its_parent() -> None:
    """As a service manager does: a world that ended at once would be taken for a crashed one, and started again."""
    with SimulationProcess.start(two_rooms(), speed=20.0) as process:
        assert process.pid is not None
        os.kill(process.pid, signal.SIGTERM)
        from_s = process.now_s()
        until(lambda: process.now_s() > from_s + 0.5)
    assert not process.alive


def test_a_world_whose_parent_does_not_end_it_ends_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    ended = threading.Event()
    monkeypatch.setattr(world_loop, "END_S", 0.0)
    monkeypatch.setattr(os, "_exit", lambda _: ended.set())
    before = signal.getsignal(signal.SIGTERM)
    try:
        world_loop.handle_signals()
        os.kill(os.getpid(), signal.SIGTERM)
        assert ended.wait(10.0)
    finally:
        signal.signal(signal.SIGTERM, before)
        signal.signal(signal.SIGINT, signal.default_int_handler)


def test_a_paused_world_still_takes_what_the_service_sends(shared: SimulationProcess) -> None:
    shared.pause()
    sender = threading.Thread(target=send_many, args=(shared, 5000), daemon=True)
    sender.start()
    sender.join(timeout=LONG_S)
    assert not sender.is_alive()
    shared.pause(False)


def test_a_killed_world_is_an_error_and_not_a_hang_and_may_be_stopped_twice() -> None:
    with SimulationProcess.start(two_rooms(), speed=20.0) as process:
        pid = process.pid
        assert pid is not None
        os.kill(pid, signal.SIGKILL)
        with pytest.raises(SimulationError, match="gone"):
            process.truth()
        process.stop()
    assert not Path(f"/proc/{pid}").exists()


def test_stopping_ends_the_process_in_order() -> None:
    process = SimulationProcess.start(two_rooms(), speed=20.0)
    pid = process.pid
    process.stop()
    process.stop()
    assert not process.alive
    assert not Path(f"/proc/{pid}").exists()
    with pytest.raises(SimulationError, match="gone"):
        process.truth()


def test_a_world_that_cannot_be_built_is_an_error_with_the_reason() -> None:
    with pytest.raises(SimulationError, match="speed must be above 0"):
        SimulationProcess.start(two_rooms(), speed=0.0)


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


PARENT = """
import time
from robots.world import load_world
from sim import SimulationProcess

if __name__ == "__main__":
    process = SimulationProcess.start(load_world("relocation_lab"), speed=None)
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
