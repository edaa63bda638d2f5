"""One process compiles a group of functions while the others wait for it, or run them as Python."""

import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from robots.compilation import (
    IN_BACKGROUND,
    Group,
    compile_once,
    compiles,
    is_being_compiled,
    is_compiled,
    uncompiled,
)
from robots.kernels import VARIABLE
from tests.waiting import until


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    return tmp_path


def test_one_compiles_while_the_others_wait_and_say_so(folder: Path) -> None:
    leave = threading.Event()
    calls: list[str] = []
    told: dict[str, list[str]] = {"first": [], "second": []}

    def compile_first() -> None:
        calls.append("compiled")
        leave.wait()

    group = Group(name="planner", compile=compile_first)
    threads = [threading.Thread(target=compile_once, args=(group, told[name].append)) for name in told]
    threads[0].start()
    until(lambda: bool(calls))
    assert is_being_compiled(group)
    threads[1].start()
    until(lambda: bool(told["second"]))
    assert told["second"] == ["waiting for another process, which compiles the planner"]
    assert not is_compiled(group)
    leave.set()
    for thread in threads:
        thread.join()
    assert told["first"] == [f"compiling the planner: once, then it is kept in {folder}"]
    assert calls == ["compiled"]
    assert is_compiled(group)
    assert not is_being_compiled(group)


def test_what_failed_to_compile_is_compiled_by_the_next(folder: Path) -> None:
    told: list[str] = []

    def fail() -> None:
        raise MemoryError

    with pytest.raises(MemoryError):
        compile_once(Group(name="planner", compile=fail), told.append)
    for _ in range(2):
        compile_once(Group(name="planner", compile=lambda: None), told.append)
    assert len(told) == 2, "the third finds it compiled"


def test_nothing_is_compiled_where_functions_run_as_python(folder: Path) -> None:
    group = Group(name="planner", compile=lambda: pytest.fail("compiled"))
    with uncompiled():
        assert not compiles()
        compile_once(group, pytest.fail)
    assert compiles()
    assert not is_compiled(group)


CHANGE_OVER = """
import sys
from pathlib import Path
from robots.compilation import Group, compiles
from robots.compiled import get_compiled
from robots.kernels import VARIABLE
from robots.physical.geometry import wrap
from sim.physics.rays import near
from tests.waiting import until
import json, os
import numpy as np

group = Group(name="some", compile=lambda: None)
points = np.array([[0.0, 0.0], [3.0, 4.0], [0.5, 0.0]])
get_compiled(group, print)
before = near(points, points[:1], 1.0).tolist()
had_numba = "numba" in sys.modules
Path(os.environ[VARIABLE], "some.compiled").touch()
until(compiles)
until(lambda: near(points, points[:1], 1.0) is not None and bool(near.dispatcher.signatures))
after = near(points, points[:1], 1.0).tolist()
print(json.dumps([before, had_numba, after]))
"""


def test_a_running_process_uses_machine_code_once_another_has_compiled_it(folder: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", CHANGE_OVER],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, IN_BACKGROUND: "1"},
    )
    before, had_numba, after = json.loads(done.stdout)
    assert not had_numba
    assert before == after == [[0, 0], [2, 0]]
