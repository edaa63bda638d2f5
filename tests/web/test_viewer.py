"""The view as a client of the service: a real viser server before a stand-in for the API."""

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
import pytest
import viser
from fastapi import Request, Response
from starlette.middleware.base import RequestResponseEndpoint
from websockets.sync.client import ClientConnection, connect

from app.cli.view_process import ViewProcess
from tests.app.berthed_store import berthed_store
from tests.ports import free_port
from tests.waiting import until
from tests.web.fake_api import TOKEN, create_app, served
from tests.web.fake_browser import SECRET, FakeBrowser, browsing
from tests.web.fake_service import WORLD, FakeService
from web.api_types import Layout, PageState
from web.scene import Frame, PageScene, palette
from web.scene.camera import CameraView
from web.scene.labels import LINE_PX
from web.scene.robots import LABEL_HEIGHT_M
from web.viewer import UPDATES_PER_LABEL_LAYOUT, Viewer, page_of
from web.world_feed import WorldFeed

PROJECT = Path(__file__).parents[2]


@pytest.fixture
def service() -> FakeService:
    return FakeService()


@pytest.fixture
def port(service: FakeService) -> int:
    return free_port()


@pytest.fixture
def viewer(port: int) -> Iterator[Viewer]:
    viewer = Viewer(
        api=f"http://127.0.0.1:{port}",
        token=TOKEN,
        port=free_port(),
        secret=SECRET,
        facts_every_s=0.05,
        retry_s=0.05,
    )
    thread = threading.Thread(target=viewer.run)
    thread.start()
    yield viewer
    viewer.stop()
    thread.join(10)
    assert not thread.is_alive()


@pytest.fixture
def browser(viewer: Viewer) -> Iterator[FakeBrowser]:
    with browsing(viewer.server.get_port()) as browser:
        yield browser


@pytest.fixture
def served_api(service: FakeService, port: int) -> Iterator[str]:
    with served(create_app(service), service, port) as api:
        yield api


def node(viewer: Viewer, name: str, page: str = "") -> Any:
    """A thing in the scene of the page's frame, None as long as it is not there."""
    for id_, stage in list(viewer.scenes.items()):
        if page_of(viewer.server, id_) == page:
            return stage.client.scene.get_handle_by_name(name)
    return None


def label(viewer: Viewer, name: str, page: str = "") -> str | None:
    handle = node(viewer, f"/labels/{name}", page)
    return None if handle is None or not handle.visible else handle.text


def shown(viewer: Viewer, name: str, page: str = "") -> bool:
    handle = node(viewer, name, page)
    return handle is not None and handle.visible


def test_the_scene_is_drawn_from_the_layout(
    viewer: Viewer, browser: FakeBrowser, served_api: str, service: FakeService
) -> None:
    until(lambda: label(viewer, "robots/store_2") == "store_2")
    for name in ("/yard/floor", "/store/aisle_2", "/walls", "/beacons", "/places/bay/bay_12"):
        assert node(viewer, name) is not None, name
    assert len(node(viewer, "/places/bay").batched_positions) == 12
    assert len(node(viewer, "/samples").batched_positions) == len(service.world.samples)
    until(lambda: browser.frames > 0)


def test_a_rack_is_drawn_by_its_berths_and_named_once(
    viewer: Viewer, service: FakeService, port: int, browser: FakeBrowser
) -> None:
    service.world = berthed_store()
    with served(create_app(service), service, port):
        until(lambda: node(viewer, "/selection/robot") is not None)
        assert len(node(viewer, "/places/bay").batched_positions) == 12 + 4
        texts = {name: node(viewer, f"/places/bay/{name}").text for name in ("bay_2", "bay_2_1", "bay_2_2")}
        assert texts == {"bay_2": "bay_2", "bay_2_1": "1", "bay_2_2": "2"}


def test_the_scene_follows_telemetry_and_facts(
    viewer: Viewer, browser: FakeBrowser, served_api: str, service: FakeService
) -> None:
    until(lambda: label(viewer, "robots/yard_1") == "yard_1")
    service.telemetry["yard_1"] |= {
        "x_m": 3.0,
        "y_m": 1.5,
        "heading_rad": 0.0,
        "packet_tag": "TRANSPORT",
        "holding": "sample_1",
    }
    until(lambda: label(viewer, "robots/yard_1") == "yard_1: TRANSPORT")
    until(lambda: node(viewer, "/robots/hull").batched_positions[0].tolist() == [3.0, 1.5, 0.0])
    until(lambda: node(viewer, "/samples").batched_positions[0][0] == pytest.approx(3.34))
    bay = service.world.location("bay_1").at
    free = node(viewer, "/places/bay").batched_colors[0].tolist()
    service.facts[0] = {"predicate": "in", "args": ["sample_1", "bay_1"]}
    service.telemetry["yard_1"]["holding"] = None
    until(lambda: node(viewer, "/samples").batched_positions[0][:2].tolist() == pytest.approx(bay))
    assert node(viewer, "/places/bay").batched_colors[0].tolist() != free


def test_the_label_of_a_sample_gives_way_to_that_of_the_robot_that_holds_it(
    viewer: Viewer, browser: FakeBrowser, served_api: str, service: FakeService
) -> None:
    until(lambda: label(viewer, "samples/sample_1"))
    service.telemetry["yard_1"]["holding"] = "sample_1"
    until(lambda: not label(viewer, "samples/sample_1"))
    until(lambda: label(viewer, "samples/sample_2"))
    # It is put down where its label has room: beside the robot's it has none.
    service.facts[0] = {"predicate": "in", "args": ["sample_1", "bay_1"]}
    service.telemetry["yard_1"]["holding"] = None
    until(lambda: label(viewer, "samples/sample_1"))
    updates = viewer.updates
    until(lambda: viewer.updates > updates + 2 * UPDATES_PER_LABEL_LAYOUT)
    assert label(viewer, "samples/sample_1"), "it stays once the labels are laid out again"


def test_the_name_of_a_place_gives_way_to_that_of_a_robot_in_front_of_it(
    viewer: Viewer, browser: FakeBrowser, served_api: str, service: FakeService
) -> None:
    until(lambda: shown(viewer, "/places/bay/bay_7"))
    name, robot = node(viewer, "/places/bay/bay_7").position, service.telemetry["store_2"]

    def is_hidden_behind_the_robot() -> bool:
        robot.update(
            x_m=name[0], y_m=south_with_its_label_on(viewer, name)
        )  # once the camera is where it belongs
        return not shown(viewer, "/places/bay/bay_7")

    until(is_hidden_behind_the_robot)
    assert shown(viewer, "/places/bay/bay_8")
    robot |= {"y_m": robot["y_m"] - 1.5}
    until(lambda: shown(viewer, "/places/bay/bay_7"))


def south_with_its_label_on(viewer: Viewer, spot: Any) -> float:
    """Where south of a spot on the floor a robot's label is on it in the picture."""
    (stage,) = viewer.scenes.values()
    view = CameraView.of(stage.client.camera)
    south = np.linspace(spot[1] - 2.0, spot[1], 200)
    labels = view.project(np.array([(spot[0], y_m, LABEL_HEIGHT_M) for y_m in south]))
    spot_px = view.project(np.array([spot]))[0, 1]
    return float(south[np.abs(labels[:, 1] - spot_px - LINE_PX / 2).argmin()])


def test_a_robot_never_heard_of_is_not_drawn_and_the_others_keep_their_colours(
    viewer: Viewer, browser: FakeBrowser, port: int, service: FakeService
) -> None:
    del service.telemetry["yard_1"]
    with served(create_app(service), service, port):
        until(lambda: label(viewer, "robots/yard_2") == "yard_2")
        until(lambda: node(viewer, "/robots/hull").batched_positions[0][2] < 0)
        assert label(viewer, "robots/yard_1") is None
        hulls = node(viewer, "/robots/hull").batched_positions
        assert hulls[1][:2].tolist() == pytest.approx(service.world.robot("yard_2").start[:2])


def test_a_world_with_nothing_in_it_is_drawn() -> None:
    server = viser.ViserServer(host="127.0.0.1", port=free_port(), verbose=False)
    layout = Layout.model_validate({"compartments": [{"name": "yard", "x": [0, 8], "y": [0, 3]}]})
    with browsing(server.get_port()):
        until(server.get_clients)
        (client,) = server.get_clients().values()
        PageScene(client, layout, lambda _kind, _name: None).update(Frame(), PageState(robot="none"), None)
        assert client.scene.get_handle_by_name("/yard/floor") is not None
    server.stop()


ONE, OTHER = "page-number-one", "page-number-two"


@pytest.fixture
def two_pages(
    viewer: Viewer, served_api: str, service: FakeService
) -> Iterator[tuple[ClientConnection, ClientConnection]]:
    """Two pages' links, each with its frame."""
    view = viewer.server.get_port()
    address = served_api.replace("http", "ws", 1)
    with (
        connect(f"{address}/v1/views/{ONE}", proxy=None) as one,
        connect(f"{address}/v1/views/{OTHER}", proxy=None) as other,
        browsing(view, ONE),
        browsing(view, OTHER),
    ):
        yield one, other


def say(page: ClientConnection, **shown: object) -> None:
    page.send(json.dumps({"world": WORLD, **shown}))


def test_what_a_page_has_selected_is_marked_in_its_own_frame_alone(
    viewer: Viewer, two_pages: tuple[ClientConnection, ClientConnection], service: FakeService
) -> None:
    one, other = two_pages
    say(one, robot="yard_1", sample="sample_2")
    say(other, robot="store_2")
    until(lambda: shown(viewer, "/selection/sample", ONE) and shown(viewer, "/selection/robot", OTHER))
    assert not shown(viewer, "/selection/sample", OTHER)
    for page, robot in ((ONE, "yard_1"), (OTHER, "store_2")):
        at = service.world.robot(robot).start[:2]
        assert node(viewer, "/selection/robot", page).position[:2] == pytest.approx(at)
    say(one)
    until(lambda: not shown(viewer, "/selection/robot", ONE))
    assert shown(viewer, "/selection/robot", OTHER)


def test_a_frame_whose_page_has_not_said_what_it_shows_stays_empty(
    viewer: Viewer, two_pages: tuple[ClientConnection, ClientConnection]
) -> None:
    one, _ = two_pages
    say(one)
    until(lambda: shown(viewer, "/robots/hull", ONE))
    assert node(viewer, "/walls", OTHER) is None


def test_nothing_is_drawn_for_a_page_whose_view_nobody_sees(
    viewer: Viewer, two_pages: tuple[ClientConnection, ClientConnection], service: FakeService
) -> None:
    one, other = two_pages
    say(one)
    say(other)
    until(lambda: shown(viewer, "/robots/hull", ONE) and shown(viewer, "/robots/hull", OTHER))
    before = _x_m(viewer, ONE)
    say(one, seen=False)
    until(lambda: not viewer.pages.states()[ONE].seen)
    updates = viewer.updates
    until(lambda: viewer.updates > updates + 1)  # the one under way may not have heard yet
    service.telemetry["yard_1"]["x_m"] = 5.0
    until(lambda: _x_m(viewer, OTHER) == pytest.approx(5.0))
    assert _x_m(viewer, ONE) == before
    say(other, seen=False)
    until(lambda: not viewer.worlds, "a world is followed that nobody sees")
    say(one)
    until(lambda: _x_m(viewer, ONE) == pytest.approx(5.0))


def test_the_floor_has_the_theme_of_the_page(
    viewer: Viewer, two_pages: tuple[ClientConnection, ClientConnection]
) -> None:
    one, other = two_pages
    say(one, dark=True)
    say(other)
    until(lambda: _floor(viewer, ONE) == palette.DARK.floors[0])
    until(lambda: _floor(viewer, OTHER) == palette.LIGHT.floors[0])
    say(one)
    until(lambda: _floor(viewer, ONE) == palette.LIGHT.floors[0])


def _floor(viewer: Viewer, page: str) -> tuple[int, ...] | None:
    floor = node(viewer, "/yard/floor", page)
    return None if floor is None else tuple(floor.color)


def test_what_is_clicked_on_is_sent_to_the_page_of_that_frame(
    viewer: Viewer, served_api: str, service: FakeService
) -> None:
    address = served_api.replace("http", "ws", 1)
    with (
        connect(f"{address}/v1/views/{ONE}", proxy=None) as page,
        browsing(viewer.server.get_port(), ONE) as frame,
    ):
        say(page)
        until(lambda: shown(viewer, "/robots/hull", ONE))
        (client,) = viewer.scenes
        names = [place.name for place in service.world.locations if place.kind == "bay"]
        for clicked, told in (
            (("/robots/hull", 1), ("robot", "yard_2")),
            (("/samples", 2), ("sample", "sample_3")),
            (("/places/bay", 4), ("place", names[4])),
        ):
            frame.click(*clicked, owner=str(client))
            assert json.loads(page.recv(timeout=20)) == dict(zip(("kind", "name"), told, strict=True))


def test_the_camera_follows_the_robot_until_the_whole_world_is_to_be_seen(
    viewer: Viewer, two_pages: tuple[ClientConnection, ClientConnection], service: FakeService
) -> None:
    one, other = two_pages
    say(one, robot="yard_1", follow=True)
    say(other, robot="yard_1")
    until(lambda: len(viewer.scenes) == 2)
    cameras = {page_of(viewer.server, id_): stage.client.camera for id_, stage in viewer.scenes.items()}
    service.telemetry["yard_1"] |= {"x_m": 3.0, "y_m": 1.5}
    until(lambda: cameras[ONE].look_at[:2].tolist() == pytest.approx([3.0, 1.5]))
    middle = cameras[OTHER].look_at.tolist()
    assert middle[:2] != pytest.approx([3.0, 1.5])
    say(one, robot="yard_1", whole=1)
    until(lambda: cameras[ONE].look_at.tolist() == pytest.approx(middle))


def test_the_ways_of_the_plan_that_a_page_shows_are_drawn(
    viewer: Viewer, two_pages: tuple[ClientConnection, ClientConnection], service: FakeService
) -> None:
    one, _ = two_pages
    service.propose("move sample_1 to bay_1")
    say(one, plan_id="plan-1")
    until(lambda: node(viewer, "/plan/heads", ONE) is not None)
    assert len(node(viewer, "/plan/heads", ONE).batched_positions) == 4  # two robots, there and on
    before = hues(viewer)
    say(one, plan_id="plan-1", action="a3")
    until(lambda: hues(viewer) and hues(viewer) != before)
    assert len(hues(viewer) & before) == 2  # of the action alone, and of the segment that is never seen
    say(one)
    until(lambda: node(viewer, "/plan/ways", ONE) is None)


def hues(viewer: Viewer) -> set[tuple[int, ...]]:
    """The colours of the ways in the first page's frame."""
    ways = node(viewer, "/plan/ways", ONE)
    return set() if ways is None else {tuple(segment[0].tolist()) for segment in ways.colors}


def test_a_page_replays_while_another_sees_what_is(
    viewer: Viewer, two_pages: tuple[ClientConnection, ClientConnection], service: FakeService
) -> None:
    one, other = two_pages
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    service.complete("mission-1")
    start_s = service.missions["mission-1"]["started_at_s"]
    say(other)
    for elapsed_s, x_m in ((0, 1), (20, 3), (30, 4), (10, 2)):
        say(one, replay={"mission_id": "mission-1", "time_s": start_s + elapsed_s})
        until(lambda x_m=x_m: _x_m(viewer, ONE) == pytest.approx(x_m))  # type: ignore[misc]
    until(lambda: _x_m(viewer, OTHER) == pytest.approx(service.world.robot("yard_1").start[0]))
    say(one)
    until(lambda: _x_m(viewer, ONE) == _x_m(viewer, OTHER))


def _x_m(viewer: Viewer, page: str) -> float | None:
    """Where yard_1 is drawn in the page's frame."""
    hulls = node(viewer, "/robots/hull", page)
    return None if hulls is None else float(hulls.batched_positions[0][0])


def test_the_view_goes_on_after_the_service_was_away(
    viewer: Viewer, browser: FakeBrowser, service: FakeService, port: int
) -> None:
    with served(create_app(service), service, port):
        until(lambda: label(viewer, "robots/yard_1") == "yard_1")
    service.telemetry["yard_1"]["packet_tag"] = "DOCK"
    with served(create_app(service), service, port):
        until(lambda: label(viewer, "robots/yard_1") == "yard_1: DOCK")


def test_a_wrong_token_leaves_the_scene_empty(service: FakeService, port: int) -> None:
    feed = WorldFeed(api=f"http://127.0.0.1:{port}", token="wrong", world=WORLD, retry_s=0.05)
    app = create_app(service)
    answers: list[int] = []

    @app.middleware("http")
    async def note(request: Request, call_next: RequestResponseEndpoint) -> Response:
        answer = await call_next(request)
        answers.append(answer.status_code)
        return answer

    with served(app, service, port):
        feed.start()
        until(lambda: len(answers) >= 4)
        feed.stop()
    assert set(answers) == {401}
    assert feed.latest.layout is None


def test_the_process_serves_its_page_and_stops_on_sigterm(service: FakeService, port: int) -> None:
    view_port = free_port()
    command = [sys.executable, "-m", "web.viewer", "--port", str(view_port)]
    with served(create_app(service), service, port) as api:
        view = subprocess.Popen(
            [*command, "--api", api],
            env={**os.environ, "MACTA_TOKEN": TOKEN, "MACTA_VIEWER_SECRET": SECRET},
            cwd=Path(__file__).parents[2],
            stdout=subprocess.DEVNULL,
        )
        try:
            until(lambda: _answers(_view_at(view_port)))
            view.send_signal(signal.SIGTERM)
            assert view.wait(10) == 0
        finally:
            view.kill()


def test_the_view_is_unused_from_the_last_request_on_while_no_browser_is_connected(
    service: FakeService, port: int
) -> None:
    time_s = [0.0]
    viewer = Viewer(
        api=f"http://127.0.0.1:{port}", token=TOKEN, port=free_port(), secret=SECRET, clock=lambda: time_s[0]
    )
    address = _view_at(viewer.server.get_port())
    try:
        time_s[0] = 50.0
        viewer.draw()
        assert viewer.unused_s == 50.0
        assert httpx2.get(address, trust_env=False).status_code == 200
        assert viewer.unused_s == 0.0
        time_s[0] = 60.0
        assert httpx2.get(address.replace(SECRET, "guess"), trust_env=False).status_code == 401
        assert viewer.unused_s == 10.0
        with browsing(viewer.server.get_port()):
            until(lambda: bool(viewer.server.get_clients()))
            time_s[0] = 100.0
            viewer.draw()
            assert viewer.unused_s == 0.0
        until(lambda: not viewer.server.get_clients())
        time_s[0] = 130.0
        viewer.draw()
        assert viewer.unused_s == 30.0
    finally:
        viewer.server.stop()


@pytest.mark.parametrize(("update_s", "wait_s"), [(0.02, 0.03), (0.2, 0.0)], ids=["quick", "slow"])
def test_updates_keep_their_rate_whatever_each_takes_and_late_ones_are_not_made_up(
    port: int, update_s: float, wait_s: float
) -> None:
    time_s = [0.0]
    waits: list[float] = []

    class Waits(threading.Event):
        def wait(self, timeout: float | None = None) -> bool:
            waits.append(timeout or 0.0)
            time_s[0] += timeout or 0.0
            return False

    def goes_on() -> bool:
        time_s[0] += update_s
        return len(waits) < 5

    viewer = Viewer(
        api=f"http://127.0.0.1:{port}",
        token=TOKEN,
        port=free_port(),
        secret=SECRET,
        stopped=Waits(),
        clock=lambda: time_s[0],
    )
    viewer.run(goes_on)
    assert waits == pytest.approx([0.0, *[wait_s] * 4])


def test_the_process_starts_in_a_folder_that_holds_another_web_package(
    service: FakeService, port: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "web").mkdir()
    (tmp_path / "web" / "__init__.py").touch()
    monkeypatch.chdir(tmp_path)
    process = ViewProcess()
    with served(create_app(service), service, port) as api:
        process.allow(api=api, token=TOKEN)
        try:
            until(lambda: process.address() is None or _answers(process.address()))
            assert process.address() is not None, "the view has ended"
            port_alone = f"http://127.0.0.1:{httpx2.URL(process.address()).port}/"
            assert httpx2.get(port_alone, trust_env=False).status_code == 401
        finally:
            process.stop()


def test_the_process_does_not_start_without_a_secret() -> None:
    command = [sys.executable, "-m", "web.viewer", "--api", "http://127.0.0.1:1", "--port", "1"]
    environment = {name: value for name, value in os.environ.items() if name != "MACTA_VIEWER_SECRET"}
    ended = subprocess.run(
        command, capture_output=True, cwd=PROJECT, timeout=60, check=False, env=environment
    )
    assert (ended.returncode, b"MACTA_VIEWER_SECRET" in ended.stderr) == (2, True)


def starting_a_view(api: str, port: int, then: str) -> list[str]:
    """A process that starts a view and then does something else."""
    start = (
        "import os, subprocess, sys; subprocess.Popen([sys.executable, '-m', 'web.viewer', '--api',"
        f" '{api}', '--port', '{port}', '--parent', str(os.getpid())]); {then}"
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
            env={**os.environ, "MACTA_VIEWER_SECRET": SECRET},
        )
        until(lambda: _answers(_view_at(view_port)))
        parent.kill()
        parent.communicate()
        until(lambda: not _answers(_view_at(view_port)))


def test_the_process_ends_also_if_the_one_that_started_it_was_gone_before_it_was_up(port: int) -> None:
    command = starting_a_view(f"http://127.0.0.1:{port}", free_port(), "sys.exit()")
    # The view holds the pipe that is read to its end.
    environment = {**os.environ, "MACTA_VIEWER_SECRET": SECRET}
    subprocess.run(command, capture_output=True, cwd=PROJECT, timeout=60, check=True, env=environment)


def _view_at(port: int) -> str:
    return f"http://relay:{SECRET}@127.0.0.1:{port}"


def _answers(address: str) -> bool:
    try:
        return httpx2.get(f"{address}/", trust_env=False).status_code == 200
    except httpx2.TransportError:
        return False
