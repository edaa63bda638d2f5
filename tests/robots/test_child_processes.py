"""Child processes: named, with their parent's environment, forked from one process with `sharing`."""

import json
import multiprocessing
import os
import subprocess
import sys
from typing import Any

import pytest

from robots.child_processes import sharing, start_child
from tests.robots import children

VARIABLE = "MACTA_TEST_OF_CHILDREN"
END_S = 60.0
SHARING = f"""
import json, multiprocessing, os, signal, sys
from pathlib import Path
from robots.child_processes import sharing, start_child
from tests.robots.children import SHARED, tell

def told(name, **options):
    near, far = multiprocessing.Pipe()
    child = start_child(tell, far, "{VARIABLE}", name=name, **options)
    far.close()
    answer = near.recv()
    child.join()
    return answer | {{"exit": child.exitcode}}

if __name__ == "__main__":
    with sharing(*sys.argv[1:], SHARED):
        os.environ["{VARIABLE}"] = "set later"
        found = [told("one"), told("other"), told("alone", shares=False)]
        os.kill(found[0]["parent"], signal.SIGKILL)
        found.append(told("restarted"))
    found.append(told("after"))
    print(json.dumps([os.getpid(), *found]))
"""
KEEPING = """
import gc, json
from pathlib import Path
import numpy
from robots.child_processes import keep_for_children

def of_files_kb():
    status = Path("/proc/self/status").read_text()
    return int(status.split("RssFile:")[1].split()[0])

numpy.linalg.inv(numpy.eye(200))
before_kb = of_files_kb()
keep_for_children()
after_kb = of_files_kb()
same = bool((numpy.linalg.inv(numpy.eye(200)) == numpy.eye(200)).all())
print(json.dumps([before_kb, after_kb, gc.get_freeze_count(), same]))
"""


def shared(*modules: str) -> list[Any]:
    """The process that shared modules, and what five children said of themselves: the third shares nothing, the fourth
    is started after the process was killed that the first two were forked from, the fifth after the block.
    """
    done = subprocess.run(
        [sys.executable, "-c", SHARING, *modules], capture_output=True, text=True, check=True, timeout=END_S
    )
    assert done.stderr == ""
    found: list[Any] = json.loads(done.stdout)
    return found


def test_a_child_has_its_name_its_parents_environment_and_no_interrupts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv(VARIABLE, "set before")
    near, far = multiprocessing.Pipe()
    child = start_child(children.tell, far, VARIABLE, name="named")
    assert near.poll(END_S)
    told = near.recv()
    child.join()
    assert told == {
        "parent": os.getpid(),
        "name": "named",
        "variable": "set before",
        "blocks_interrupts": True,
        "has_shared": False,
    }


def test_without_what_they_are_forked_from_children_are_started_alone(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail() -> None:
        raise OSError("no folder for it")

    monkeypatch.setattr("robots.child_processes.ensure_running", fail)
    near, far = multiprocessing.Pipe()
    with sharing(children.SHARED):
        child = start_child(children.tell, far, VARIABLE, name="alone")
    assert near.poll(END_S)
    told = near.recv()
    child.join()
    assert (told["parent"], told["has_shared"]) == (os.getpid(), False)
    assert "no folder for it" in caplog.text


def test_children_are_forked_from_one_process_that_has_what_they_share() -> None:
    me, one, other, alone, restarted, after = shared()
    assert one == {
        "parent": one["parent"],
        "name": "one",
        "variable": "set later",
        "blocks_interrupts": True,
        "has_shared": True,
        "exit": 0,
    }
    assert one["parent"] == other["parent"] != me
    assert restarted["parent"] not in (me, one["parent"]), "killed, it is started again"
    assert restarted["has_shared"]
    for unrelated in (alone, after):
        assert (unrelated["parent"], unrelated["has_shared"]) == (me, False)


def test_a_module_that_is_missing_is_left_out() -> None:
    assert [told["has_shared"] for told in shared("robots.no_such_module")[1:4]] == [True, True, False]


def test_what_only_loading_needed_of_libraries_is_given_back_and_read_again_if_needed() -> None:
    done = subprocess.run([sys.executable, "-c", KEEPING], capture_output=True, text=True, check=True)
    before_kb, after_kb, frozen, same = json.loads(done.stdout)
    assert after_kb < before_kb / 2
    assert frozen > 0
    assert same
