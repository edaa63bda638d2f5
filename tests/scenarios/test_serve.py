"""`macta serve` from start to end, as a process."""

import signal
import subprocess
from pathlib import Path

import httpx2
import pytest

from tests.scenarios.serving import END_S, macta_serve


@pytest.mark.parametrize("ending", [signal.SIGTERM, signal.SIGINT])
def test_the_service_says_where_it_is_keeps_its_token_and_ends_in_order(
    tmp_path: Path, ending: signal.Signals
) -> None:
    data = tmp_path / "data"
    with macta_serve(data) as served:
        assert httpx2.get(f"{served.address}/readyz").json() == {"status": "ready"}
        assert (data / "token").read_text().strip() == served.token
        assert (data / "token").stat().st_mode & 0o077 == 0
        assert httpx2.get(served.console).status_code == 303
        with httpx2.stream(
            "GET", f"{served.address}/v1/events", headers={"authorization": f"Bearer {served.token}"}
        ) as stream:
            served.process.send_signal(ending)
            served.process.wait(timeout=END_S)
            assert list(stream.iter_lines()) is not None
        assert served.process.returncode == 0
        assert served.process.stderr is not None
        assert "Traceback" not in served.process.stderr.read()
    assert _children_of(served.process.pid) == []


def test_a_port_that_is_taken_is_said_in_a_line(tmp_path: Path) -> None:
    with macta_serve(tmp_path / "one") as first:
        port = first.address.rsplit(":", 1)[1]
        with (
            pytest.raises(AssertionError, match=f"cannot listen on 127.0.0.1:{port}"),
            macta_serve(tmp_path / "two", "--port", port),
        ):
            pass


def _children_of(pid: int) -> list[str]:
    """Processes of that process' session that are still there."""
    found = subprocess.run(["pgrep", "-P", str(pid)], capture_output=True, text=True, check=False)
    return found.stdout.split()
