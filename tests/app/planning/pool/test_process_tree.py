"""The descendants of a process, as /proc tells them."""

from pathlib import Path

import pytest

from app.planning.pool import process_tree


def process(folder: Path, pid: int, *threads: str | None) -> None:
    """A process whose threads have these children; None: of a thread that has ended since it was listed."""
    for number, children in enumerate(threads):
        thread = folder / str(pid) / "task" / str(pid + number)
        thread.mkdir(parents=True)
        if children is not None:
            (thread / "children").write_text(children)
    fields = " ".join(["S", *["0"] * 18, f"{pid}00"])
    (folder / str(pid) / "stat").write_text(f"{pid} (a process) {fields}")


def test_a_thread_that_ends_meanwhile_hides_no_child_of_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(process_tree, "PROCESSES", tmp_path)
    process(tmp_path, 10, "20 ", None, "30 40 ")
    process(tmp_path, 20, "50 ")
    for pid in (30, 50):
        process(tmp_path, pid, "")
    assert {one.pid for one in process_tree.tree_of(10)} == {10, 20, 30, 50}, "40 has ended"
