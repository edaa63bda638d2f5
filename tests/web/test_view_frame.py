"""The view of the world inside the console: a real browser, the relay and a real viser server."""

import threading
from collections.abc import Iterator

import numpy as np
import pytest
import viser

from tests.waiting import until
from tests.web.fake_api import TOKEN, add_console, create_app, free_port, served
from tests.web.fake_browser import SECRET
from tests.web.fake_service import FakeService
from tests.web.page_controls import boxes, hide
from web.scene import palette
from web.scene.camera import CameraView
from web.viewer import Viewer

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Browser, FloatRect, Page, WebSocket, expect  # noqa: E402

pytestmark = pytest.mark.browser


@pytest.fixture
def page(webgl_browser: Browser) -> Iterator[Page]:
    context = webgl_browser.new_context(viewport={"width": 1280, "height": 720}, device_scale_factor=0.5)
    yield context.new_page()
    context.close()


def test_the_view_comes_when_it_is_there_and_comes_back_though_another_field_has_the_focus(
    page: Page,
) -> None:
    service, port = FakeService(), free_port()
    app = create_app(service)
    service.view = f"http://127.0.0.1:{port}"
    add_console(app)
    talking: set[WebSocket] = set()
    page.on("websocket", lambda socket: socket.on("framereceived", lambda _: talking.add(socket)))

    def until_talking(count: int) -> None:
        until(lambda: page.wait_for_timeout(100) or len(talking) >= count, "too few sockets bring frames")

    with served(app, service) as address:
        page.goto(f"{address}/?token={TOKEN}")
        expect(page.locator("#stage-note")).to_contain_text("is starting")
        first = viser.ViserServer(host="127.0.0.1", port=port, verbose=False)
        until_talking(1)
        expect(page.locator("#stage")).to_be_visible()
        page.get_by_test_id("goal-text").click()
        first.stop()
        second = viser.ViserServer(host="127.0.0.1", port=port, verbose=False)
        until_talking(2)
        second.stop()


HOVERED = "() => [...document.querySelectorAll('canvas')].some((one) => one.style.cursor === 'pointer')"


class Pointer:
    """Moves about the world inside the frame, by places in the world."""

    def __init__(self, page: Page, viewer: Viewer) -> None:
        self._page, self._viewer = page, viewer

    def click(self, at: tuple[float, float, float]) -> None:
        """Click on what is there, once the browser has drawn it."""
        until(lambda: not self._hovers(5.0, 5.0))  # else what was clicked on last would count
        until(lambda: self._hovers(*self._picture_of(at)), what=f"nothing to click on at {at}")
        self._page.mouse.down()
        self._page.mouse.up()

    def _picture_of(self, at: tuple[float, float, float]) -> tuple[float, float]:
        """Where in the frame it is, pixels; its corner as long as there is nothing."""
        stages = list(self._viewer.scenes.values())
        if not stages:
            return 5.0, 5.0
        view = CameraView.of(stages[0].client.camera)
        x, y, _ = view.project(np.array([at]))[0] * self._box["width"] / view.width_px
        return x, y

    @property
    def _box(self) -> FloatRect:
        box = self._page.locator("#stage").bounding_box()
        assert box is not None
        return box

    def _hovers(self, x: float, y: float) -> bool:
        """Move there; whether there is something to click on."""
        expect(self._page.locator("#stage")).to_be_visible()
        self._page.mouse.move(self._box["x"] + x + 1, self._box["y"] + y)
        self._page.mouse.move(self._box["x"] + x, self._box["y"] + y)
        self._page.wait_for_timeout(100)
        frame = self._page.locator("#stage").element_handle().content_frame()
        return bool(frame and frame.evaluate(HOVERED))


@pytest.fixture
def viewed() -> Iterator[tuple[FakeService, Viewer, str]]:
    """The service with the view beside it."""
    service = FakeService()
    app = create_app(service)
    add_console(app)
    with served(app, service) as address:
        viewer = Viewer(
            api=address, token=TOKEN, port=free_port(), secret=SECRET, facts_every_s=0.1, retry_s=0.1
        )
        service.view = f"http://relay:{SECRET}@127.0.0.1:{viewer.server.get_port()}"
        thread = threading.Thread(target=viewer.run)
        thread.start()
        yield service, viewer, address
        viewer.stop()
        thread.join(10)


def test_what_is_clicked_on_in_three_dimensions_is_picked_on_the_page(
    page: Page, viewed: tuple[FakeService, Viewer, str]
) -> None:
    service, viewer, address = viewed
    page.goto(f"{address}/?token={TOKEN}")
    pointer = Pointer(page, viewer)
    sample = service.world.samples[1]
    pointer.click((*service.world.location(sample.at).at, 0.1))
    expect(page.locator("#pick-note")).to_contain_text(sample.name)
    pointer.click((*service.world.location("bay_7").at, 0.0))
    expect(page.get_by_test_id("goal-text")).to_have_value(f"move {sample.name} to bay_7")
    pointer.click((*service.world.robot("yard_2").start[:2], 0.15))
    expect(page.get_by_test_id("robot-panel")).to_contain_text("yard_2")
    expect(page.get_by_test_id("robot").filter(has_text="yard_2")).to_have_attribute("aria-pressed", "true")


def test_what_is_selected_and_replayed_on_the_page_is_shown_in_three_dimensions(
    page: Page, viewed: tuple[FakeService, Viewer, str]
) -> None:
    service, _, address = viewed
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    service.complete("mission-1")
    page.goto(f"{address}/?token={TOKEN}")
    until(lambda: service.views.ids)
    (view,) = service.views.ids
    page.get_by_test_id("robot").filter(has_text="store_1").click()
    page.locator("#follow").click()
    until(lambda: (shown := service.views.shown(view)) and (shown.robot, shown.follow) == ("store_1", True))
    page.locator("#whole").click()
    until(lambda: (shown := service.views.shown(view)) and (shown.whole, shown.follow) == (1, False))
    page.get_by_test_id("mission-replay").click()
    page.get_by_test_id("replay-time").fill("20")
    began_s = service.missions["mission-1"]["started_at_s"]
    until(lambda: _replayed(service, view) == ("mission-1", began_s + 20))
    page.get_by_test_id("replay-close").click()
    until(lambda: _replayed(service, view) is None)


def test_the_view_hears_whether_anyone_sees_it_and_in_what_theme(
    page: Page, viewed: tuple[FakeService, Viewer, str]
) -> None:
    service, _, address = viewed
    page.goto(f"{address}/?token={TOKEN}")
    until(lambda: service.views.ids)
    (view,) = service.views.ids

    def told(*, seen: bool, dark: bool = False) -> bool:
        shown = service.views.shown(view)
        return shown is not None and (shown.seen, shown.dark) == (seen, dark)

    until(lambda: told(seen=True))
    hide(page)
    until(lambda: told(seen=False))
    hide(page, hidden=False)
    until(lambda: told(seen=True))
    page.locator("#as-map").click()
    until(lambda: told(seen=False))
    page.locator("#as-view").click()
    until(lambda: told(seen=True))
    page.locator("#theme").select_option("dark")
    until(lambda: told(seen=True, dark=True))


def test_the_view_is_not_fetched_before_it_is_wanted(
    page: Page, viewed: tuple[FakeService, Viewer, str]
) -> None:
    service, _, address = viewed
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url.removeprefix(address)))
    page.add_init_script("localStorage.setItem('macta.world-as', JSON.stringify('map'))")
    page.goto(f"{address}/?token={TOKEN}")
    expect(page.get_by_test_id("invitation")).to_be_visible()
    assert "/v1/view" not in asked
    page.locator("#as-view").click()
    until(lambda: service.views.ids)
    expect(page.locator("#stage")).to_be_visible()


def _replayed(service: FakeService, view: str) -> tuple[str, float] | None:
    shown = service.views.shown(view)
    return shown.replay and (shown.replay.mission_id, shown.replay.time_s) if shown else None


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_software_rendering_is_noted_beside_the_world_and_covers_none_of_it(
    page: Page, viewed: tuple[FakeService, Viewer, str], theme: str
) -> None:
    _, _, address = viewed
    page.add_init_script(f"localStorage.setItem('macta.theme', JSON.stringify('{theme}'))")
    page.goto(f"{address}/?token={TOKEN}")
    expect(page.locator("#software-note")).to_be_visible()
    notice = page.frame_locator("#stage").locator("#webgl-software-rendering")
    expect(notice).to_have_count(1)  # else viser has renamed its notice
    expect(notice).to_be_hidden()
    stage, note = boxes(page, "#stage-holder", "#software-note")
    assert note["y"] >= stage["y"] + stage["height"]
    page.locator("#as-map").click()
    expect(page.locator("#software-note")).to_be_hidden()


def test_the_legend_has_the_colours_of_the_view(page: Page, viewed: tuple[FakeService, Viewer, str]) -> None:
    _, _, address = viewed
    page.goto(f"{address}/?token={TOKEN}")
    page.locator("#legend summary").click()
    swatches = page.locator("#legend .swatch")
    expect(swatches.first).to_be_visible()
    told = swatches.evaluate_all("all => all.map((one) => one.style.background)")
    colours = [palette.SELECTED, palette.SAMPLE, palette.PLACES["bay"], palette.OCCUPIED, palette.BEACON]
    assert {f"rgb{colour}" for colour in [*colours, palette.WHISKER_HIT]} <= set(told)
