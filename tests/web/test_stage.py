"""The view of the world inside the console: a real browser, the relay and a real viser server."""

import shutil
from collections.abc import Iterator

import pytest
import viser

from app.api.viewer_proxy import viewer_router
from tests.web.fake_api import TOKEN, add_console, create_app, free_port, served
from tests.web.fake_service import FakeService

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Page, WebSocket, expect, sync_playwright  # noqa: E402

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine"),
]
SOFTWARE_GL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
FLAGS = ["--no-sandbox", "--disable-quic", "--disable-background-networking", "--disable-sync", *SOFTWARE_GL]


@pytest.fixture
def page() -> Iterator[Page]:
    with sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield chromium.new_page(viewport={"width": 1280, "height": 720})
        chromium.close()


def test_the_view_comes_when_it_is_there_and_comes_back_though_another_field_has_the_focus(
    page: Page,
) -> None:
    service, port = FakeService(), free_port()
    app = create_app(service)
    upstream = f"http://127.0.0.1:{port}"
    app.include_router(viewer_router(lambda: upstream, lambda asking: asking.cookies.get("macta") == TOKEN))
    add_console(app)
    talking: set[WebSocket] = set()
    page.on("websocket", lambda socket: socket.on("framereceived", lambda _: talking.add(socket)))

    def until_talking(count: int) -> None:
        for _ in range(200):
            if len(talking) >= count:
                return
            page.wait_for_timeout(100)
        raise AssertionError(f"{len(talking)} of {count} connections brought frames")

    with served(app, service) as address:
        page.goto(f"{address}/?token={TOKEN}")
        expect(page.locator("#stage-note")).to_contain_text("not there yet")
        first = viser.ViserServer(host="127.0.0.1", port=port, verbose=False)
        until_talking(1)
        expect(page.locator("#stage")).to_be_visible()
        page.get_by_test_id("goal-text").click()
        first.stop()
        second = viser.ViserServer(host="127.0.0.1", port=port, verbose=False)
        until_talking(2)
        second.stop()
