"""A process in the background compiles, once; the others go on meanwhile."""

import os
import signal
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

from app.background_compilation import BackgroundCompilation, Stage
from robots.compilation import IN_BACKGROUND, Group, compile_once, is_compiled, uncompiled
from robots.kernels import VARIABLE
from tests.waiting import until


def note(file: Path) -> None:
    """Stands for compilation: note the process that does it."""
    with file.open("a") as noted:
        noted.write(f"{os.getpid()} {os.getpriority(os.PRIO_PROCESS, 0)}\n")


def wait_for(noted: Path, leave: Path) -> None:
    """Note the process, and go on once the file is there."""
    note(noted)
    until(leave.exists)


def fail(noted: Path) -> None:
    note(noted)
    raise MemoryError


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    yield tmp_path
    assert IN_BACKGROUND not in os.environ


def processes(file: Path) -> list[int]:
    """The processes that noted themselves."""
    return [int(line.split()[0]) for line in file.read_text().splitlines()] if file.exists() else []


def test_groups_are_compiled_in_one_process_of_low_priority(folder: Path) -> None:
    noted = folder / "noted"
    groups = [Group(name=name, compile=partial(note, noted)) for name in ("planner", "simulation")]
    told: list[str] = []
    changes: list[Stage] = []
    compilation = BackgroundCompilation(groups, tell=told.append)
    compilation.when_changed(lambda: changes.append(compilation.stage))
    assert compilation.stage is Stage.COMPILING
    compilation.start()
    until(lambda: "everything is compiled" in told)
    assert told[0] == "compiling the planner and the simulation, once"
    assert compilation.stage is Stage.COMPILED
    assert changes[-1] is Stage.COMPILED
    one, other = noted.read_text().splitlines()
    assert one == other
    assert int(one.split()[0]) != os.getpid()
    assert int(one.split()[1]) > os.getpriority(os.PRIO_PROCESS, 0)
    compilation.close()


def test_what_is_compiled_already_takes_no_process(folder: Path) -> None:
    group = Group(name="planner", compile=lambda: None)
    compile_once(group, str)
    compilation = BackgroundCompilation([group], tell=pytest.fail)
    assert compilation.stage is compilation.stage_of("planner") is Stage.COMPILED
    compilation.start()
    compilation.close()


def test_while_another_process_compiles_it_is_waited_for_and_taken_over_if_that_is_killed(
    folder: Path,
) -> None:
    noted = folder / "noted"
    leave = folder / "leave"
    group = Group(name="planner", compile=partial(wait_for, noted, leave))
    first = BackgroundCompilation([group], tell=str)
    first.start()
    until(lambda: len(processes(noted)) == 1)
    told: list[str] = []
    second = BackgroundCompilation([group], tell=told.append)
    second.start()
    until(lambda: second.stage is Stage.WAITING and told)
    assert told == ["another process compiles the planner"]
    os.kill(processes(noted)[0], signal.SIGKILL)
    until(lambda: len(processes(noted)) >= 2)
    leave.touch()
    until(lambda: second.stage is first.stage is Stage.COMPILED)
    first.close()
    second.close()


def test_what_cannot_be_compiled_stays_uncompiled_and_is_tried_again_at_the_next_start(folder: Path) -> None:
    noted = folder / "noted"
    failing = BackgroundCompilation([Group(name="planner", compile=partial(fail, noted))], tell=str)
    failing.start()
    until(lambda: failing.stage is Stage.UNCOMPILED)
    assert len(processes(noted)) == 2
    failing.close()
    again = BackgroundCompilation([Group(name="planner", compile=partial(note, noted))], tell=str)
    again.start()
    until(lambda: again.stage is Stage.COMPILED)
    again.close()


def test_the_compiling_process_ends_with_its_service(folder: Path) -> None:
    noted = folder / "noted"
    group = Group(name="planner", compile=partial(wait_for, noted, folder / "never"))
    compilation = BackgroundCompilation([group], tell=str)
    compilation.start()
    until(lambda: bool(processes(noted)))
    compilation.close()
    with pytest.raises(ProcessLookupError):
        os.kill(processes(noted)[0], 0)
    assert not is_compiled(group)


def test_with_compilation_switched_off_nothing_is_compiled(folder: Path) -> None:
    with uncompiled():
        compilation = BackgroundCompilation([Group(name="planner", compile=str)], tell=pytest.fail)
        compilation.start()
        assert compilation.stage is Stage.UNCOMPILED
        compilation.close()
