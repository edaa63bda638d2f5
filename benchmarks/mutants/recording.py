"""A pytest plugin that records which lines each test executes, and how long the test takes.

`FOLDER` names the folder for what is recorded; it contains `MODULES`, the paths of the modules to record, a line each.
"""

import json
import os
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from coverage import Coverage

FOLDER = "MACTA_REACH"
MODULES = "modules"
LINES = "lines"
"""The file of the lines executed, as coverage.py writes it; each worker's has a suffix."""
TESTS = "tests"
"""A folder with a file for each worker: the seconds of each test that passed."""


class Recording:
    """Lines and durations of the tests of one process."""

    def __init__(self, folder: Path) -> None:
        modules = (folder / MODULES).read_text().splitlines()
        self._coverage = Coverage(
            data_file=str(folder / LINES), data_suffix=True, include=modules, config_file=False
        )
        # Tests treat a warning as an error; a worker whose tests execute none of the modules has no data.
        self._coverage.set_option("run:disable_warnings", ["no-data-collected"])
        self._passed: dict[str, float] = {}
        self._failed: set[str] = set()
        self._file = folder / TESTS / f"{os.getpid()}.json"
        self._coverage.start()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[object]:
        self._coverage.switch_context(item.nodeid)
        begun = time.monotonic()
        ended = yield
        self._passed[item.nodeid] = time.monotonic() - begun
        self._coverage.switch_context("")
        return ended

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if not report.passed:
            self._failed.add(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        self._coverage.stop()
        self._coverage.save()
        passed = {test: seconds for test, seconds in self._passed.items() if test not in self._failed}
        self._file.write_text(json.dumps(passed))


def pytest_configure(config: pytest.Config) -> None:
    if not hasattr(config, "workerinput") and config.getoption("numprocesses"):
        return  # the workers run the tests
    config.pluginmanager.register(Recording(Path(os.environ[FOLDER])))
