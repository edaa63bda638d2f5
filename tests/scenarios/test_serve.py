"""`macta serve` from start to end, as a process."""

import signal
from pathlib import Path

import httpx2

from app.planning.pool.process_tree import tree_of
from tests.scenarios.serving import END_S, macta_serve
from tests.waiting import read_until, until


def test_the_service_says_where_it_is_keeps_its_token_and_ends_in_order(tmp_path: Path) -> None:
    """By Ctrl-C; every other service that a scenario starts is ended by SIGTERM."""
    data = tmp_path / "data"
    with macta_serve(data) as served:
        assert httpx2.get(f"{served.address}/readyz").json()["status"] == "ready"
        assert (data / "token").read_text().strip() == served.token
        assert (data / "token").stat().st_mode & 0o077 == 0
        assert httpx2.get(served.console).status_code == 303
        bearer = {"authorization": f"Bearer {served.token}"}
        with httpx2.Client(base_url=served.address, headers=bearer) as api:
            read_until(api, "/v1/view", lambda view: view["running"])
        family = tree_of(served.process.pid)
        assert len(family) > 4, (
            "itself, the world, a planning process and the view, and what tracks their resources"
        )
        with httpx2.stream("GET", f"{served.address}/v1/events", headers=bearer) as stream:
            served.process.send_signal(signal.SIGINT)
            served.process.wait(timeout=END_S)
            assert list(stream.iter_lines()) is not None
        assert served.process.returncode == 0
        assert served.process.stderr is not None
        assert "Traceback" not in served.process.stderr.read()
    until(lambda: not [one for one in family if one.is_alive], "a process is left behind")
