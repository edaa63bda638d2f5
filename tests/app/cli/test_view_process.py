"""When the process of the 3D view is started; what it does: `tests/web/test_viewer.py`."""

import sys
from pathlib import Path

import pytest

from app.cli.view_process import RESTART_S, ViewProcess
from tests.app.stepped_clock import SteppedClock
from tests.waiting import until


def test_it_is_started_by_the_first_question_for_its_address_once_it_may_run() -> None:
    view = ViewProcess()
    assert view.address() is None
    view.allow(api="http://127.0.0.1:1", token="any")
    try:
        address = view.address()
        assert address is not None
        assert view.address() == address
    finally:
        view.stop()
    assert view.address() is None


def test_one_that_has_ended_is_started_again_but_not_by_every_question(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    starts = tmp_path / "starts"
    program = tmp_path / "program"
    program.write_text(f"#!/bin/sh\necho started >> {starts}\n")
    program.chmod(0o700)
    monkeypatch.setattr(sys, "executable", str(program))
    clock = SteppedClock()
    view = ViewProcess(clock)
    view.allow(api="http://127.0.0.1:1", token="any")
    view.address()
    until(lambda: starts.exists() and view.address() is None)
    clock.advance(RESTART_S - 0.1)
    assert view.address() is None
    assert starts.read_text() == "started\n"
    clock.advance(0.2)
    view.address()
    until(lambda: starts.read_text() == "started\n" * 2)
    view.stop()
