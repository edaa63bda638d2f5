"""A service process that does not start is given up by the trial's own clock."""

import subprocess
from pathlib import Path

import pytest

from app.cli.trials.service_process import READY_TIMEOUT_S, NotReady, ServiceProcess
from tests.app.stepped_clock import SteppedClock


class HangingProcess:
    """A process that neither writes its address nor ends."""

    def poll(self) -> None:
        return None


def test_a_service_that_does_not_report_its_address_in_time_is_not_ready(tmp_path: Path) -> None:
    clock = SteppedClock()
    out = tmp_path / "out"
    err = tmp_path / "err"
    out.write_text("")
    err.write_text("waiting for the database")
    process: subprocess.Popen[bytes] = HangingProcess()  # type: ignore[assignment]
    service = ServiceProcess(
        number=1, process=process, out=out, err=err, token="t", data=tmp_path, clock=clock
    )
    began_s = clock.monotonic_s()
    with pytest.raises(NotReady, match="waiting for the database"):
        service.address()
    assert clock.monotonic_s() - began_s >= READY_TIMEOUT_S
