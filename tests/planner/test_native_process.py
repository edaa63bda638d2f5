"""Native engines as limited processes."""

import os
import sys
import time
from pathlib import Path

from planner.native_process import Limits, run

LONG = 60.0


def within(seconds: float, memory_mb: int = 2048) -> Limits:
    return Limits(seconds, memory_mb=memory_mb)


def python(script: str) -> list[str]:
    return [sys.executable, "-S", "-c", script]


def test_output_and_exit_code_come_back(tmp_path: Path) -> None:
    ended = run(python("print('found'); raise SystemExit(3)"), folder=tmp_path, limits=within(LONG))
    assert (ended.code, ended.output) == (3, "found\n")


def test_a_process_is_ended_at_its_deadline_with_all_it_started(tmp_path: Path) -> None:
    script = (
        "import subprocess, sys, time\n"
        "child = subprocess.Popen([sys.executable, '-S', '-c', 'import time; time.sleep(60)'])\n"
        "open('child', 'w').write(str(child.pid))\n"
        "time.sleep(60)"
    )

    def has_child() -> bool:
        return (tmp_path / "child").is_file() and (tmp_path / "child").read_text() != ""

    ended = run(python(script), folder=tmp_path, limits=within(LONG), is_enough=has_child)
    assert ended.code is None
    assert gone(int((tmp_path / "child").read_text()))


def gone(pid: int) -> bool:
    """True once the process has ended (a killed one is nobody's for a moment)."""
    for _ in range(500):
        try:
            os.kill(pid, 0)
            state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
        except (ProcessLookupError, FileNotFoundError):
            return True
        if state == "Z":
            return True
        time.sleep(0.01)
    return False


def test_a_deadline_that_is_past_ends_at_once(tmp_path: Path) -> None:
    assert run(python("import time; time.sleep(60)"), folder=tmp_path, limits=within(0.2)).code is None


def test_memory_beyond_the_limit_is_refused(tmp_path: Path) -> None:
    ended = run(python("bytearray(2 * 10**9)"), folder=tmp_path, limits=within(LONG, memory_mb=500))
    assert ended.code == 1
    assert "MemoryError" in ended.output


def test_much_output_does_not_block(tmp_path: Path) -> None:
    ended = run(python("print('x' * 10**6)"), folder=tmp_path, limits=within(LONG))
    assert len(ended.output) == 10**6 + 1
