"""The view as a client of the service: a real viser server before a stand-in for the API."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest

from tests.app.berthed_store import berthed_store
from tests.web.fake_api import TOKEN, create_app, free_port, served
from tests.web.fake_service import WORLD, FakeService
from web.feed import WorldFeed
from web.viewer import Viewer

PROJECT = Path(__file__).parents[2]


def until(rule: Callable[[], bool], timeout_s: float = 15.0) -> None:
    deadline = time.monotonic() + timeout_s
    while not rule():
        assert time.monotonic() < deadline, "did not come true in time"
        time.sleep(0.02)


@pytest.fixture
def service() -> FakeService:
    return FakeService()


@pytest.fixture
def port(service: FakeService) -> int:
    return free_port()


@pytest.fixture
def viewer(port: int) -> Iterator[Viewer]:
    feed = WorldFeed(
        api=f"http://127.0.0.1:{port}", token=TOKEN, world=WORLD, facts_every_s=0.05, again_s=0.05
    )
    viewer = Viewer(feed=feed, port=free_port())
    thread = threading.Thread(target=viewer.run)
    thread.start()
    yield viewer
    viewer.stop()
    thread.join(10)
    assert not thread.is_alive()


def node(viewer: Viewer, name: str) -> Any:
    return viewer.server.scene.get_handle_by_name(name)


def label(viewer: Viewer, robot: str) -> str | None:
    handle = node(viewer, f"/robots/{robot}/label")
    return None if handle is None or not handle.visible else handle.text


def test_the_scene_is_drawn_from_the_layout(viewer: Viewer, service: FakeService, port: int) -> None:
    with served(create_app(service), service, port):
        # The samples are drawn last: a label is there, and for a moment visible, before all is built.
        until(lambda: node(viewer, "/samples") is not None)
        until(lambda: label(viewer, "store_2") == "store_2")
        for name in ("/yard/floor", "/store/aisle_2", "/walls", "/beacons", "/places/bay/bay_12"):
            assert node(viewer, name) is not None, name
        assert len(node(viewer, "/places/bay").batched_positions) == 12
        assert len(node(viewer, "/samples").batched_positions) == len(service.world.samples)
        _, camera_y, camera_z = viewer.server.initial_camera.position
        assert camera_y < 0 < camera_z


def test_a_rack_is_drawn_by_its_berths_and_named_once(
    viewer: Viewer, service: FakeService, port: int
) -> None:
    service.world = berthed_store()
    with served(create_app(service), service, port):
        until(lambda: node(viewer, "/samples") is not None)
        assert len(node(viewer, "/places/bay").batched_positions) == 12 + 4
        texts = {name: node(viewer, f"/places/bay/{name}").text for name in ("bay_2", "bay_2_1", "bay_2_2")}
        assert texts == {"bay_2": "bay_2", "bay_2_1": "1", "bay_2_2": "2"}


def test_the_scene_follows_telemetry_and_facts(viewer: Viewer, service: FakeService, port: int) -> None:
    with served(create_app(service), service, port):
        until(lambda: label(viewer, "yard_1") == "yard_1")
        service.telemetry["yard_1"] |= {
            "x_m": 3.0,
            "y_m": 1.5,
            "heading_rad": 0.0,
            "packet_tag": "TRANSPORT",
            "holding": "sample_1",
        }
        until(lambda: label(viewer, "yard_1") == "yard_1: TRANSPORT")
        assert node(viewer, "/robots/hull").batched_positions[0].tolist() == [3.0, 1.5, 0.0]
        until(lambda: node(viewer, "/samples").batched_positions[0][0] == pytest.approx(3.34))
        service.facts[0] = {"predicate": "in", "args": ["sample_1", "bay_1"]}
        service.telemetry["yard_1"]["holding"] = None
        bay = service.world.location("bay_1").at
        until(lambda: node(viewer, "/samples").batched_positions[0][:2].tolist() == pytest.approx(bay))


def test_the_label_of_a_sample_gives_way_to_that_of_the_robot_that_holds_it(
    viewer: Viewer, service: FakeService, port: int
) -> None:
    def labelled() -> bool:
        handle = node(viewer, "/samples/sample_1")
        return handle is not None and handle.visible

    with served(create_app(service), service, port):
        until(lambda: labelled() and node(viewer, "/samples").batched_positions[0][2] == 0)
        service.telemetry["yard_1"]["holding"] = "sample_1"
        until(lambda: not labelled() and node(viewer, "/samples").batched_positions[0][2] > 0)
        until(lambda: node(viewer, "/samples/sample_2").visible)
        service.telemetry["yard_1"]["holding"] = None
        until(labelled)


def test_a_robot_never_heard_of_is_not_drawn_and_the_others_keep_their_colours(
    viewer: Viewer, service: FakeService, port: int
) -> None:
    del service.telemetry["yard_1"]
    with served(create_app(service), service, port):
        until(lambda: label(viewer, "yard_2") == "yard_2")
        assert label(viewer, "yard_1") is None
        until(lambda: node(viewer, "/robots/hull").batched_positions[0][2] < 0)  # the label is drawn first
        hulls = node(viewer, "/robots/hull").batched_positions
        assert hulls[1][:2].tolist() == pytest.approx(service.world.robot("yard_2").start[:2])


def test_the_view_goes_on_after_the_service_was_away(viewer: Viewer, service: FakeService, port: int) -> None:
    with served(create_app(service), service, port):
        until(lambda: label(viewer, "yard_1") == "yard_1")
    service.telemetry["yard_1"]["packet_tag"] = "DOCK"
    with served(create_app(service), service, port):
        until(lambda: label(viewer, "yard_1") == "yard_1: DOCK")


def test_a_wrong_token_leaves_the_scene_empty(service: FakeService, port: int) -> None:
    feed = WorldFeed(api=f"http://127.0.0.1:{port}", token="wrong", world=WORLD, again_s=0.05)
    with served(create_app(service), service, port):
        feed.start()
        assert feed.latest(after=0, timeout_s=0.5).layout is None
        feed.stop()


def test_the_process_serves_its_page_and_stops_on_sigterm(service: FakeService, port: int) -> None:
    view_port = free_port()
    command = [sys.executable, "-m", "web.viewer", "--port", str(view_port), "--world", WORLD]
    with served(create_app(service), service, port) as api:
        view = subprocess.Popen(
            [*command, "--api", api],
            env={**os.environ, "MACTA_TOKEN": TOKEN},
            cwd=Path(__file__).parents[2],
            stdout=subprocess.DEVNULL,
        )
        try:
            until(lambda: _answers(view_port))
            view.send_signal(signal.SIGTERM)
            assert view.wait(10) == 0
        finally:
            view.kill()


def starting_a_view(api: str, port: int, then: str) -> list[str]:
    """A process that starts a view and then does something else."""
    start = (
        "import os, subprocess, sys; subprocess.Popen([sys.executable, '-m', 'web.viewer', '--api',"
        f" '{api}', '--port', '{port}', '--world', '{WORLD}', '--parent', str(os.getpid())]); {then}"
    )
    return [sys.executable, "-c", start]


def test_the_process_ends_with_the_one_that_started_it(service: FakeService, port: int) -> None:
    view_port = free_port()
    with served(create_app(service), service, port) as api:
        parent = subprocess.Popen(
            starting_a_view(api, view_port, "sys.stdin.read()"),
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            cwd=PROJECT,
        )
        until(lambda: _answers(view_port))
        parent.kill()
        parent.communicate()
        until(lambda: not _answers(view_port))


def test_the_process_ends_also_if_the_one_that_started_it_was_gone_before_it_was_up(port: int) -> None:
    command = starting_a_view(f"http://127.0.0.1:{port}", free_port(), "sys.exit()")
    # The view holds the pipe that is read to its end.
    subprocess.run(command, capture_output=True, cwd=PROJECT, timeout=60, check=True)


def _answers(port: int) -> bool:
    try:
        return httpx2.get(f"http://127.0.0.1:{port}/", trust_env=False).status_code == 200
    except httpx2.TransportError:
        return False
