"""Costs of the operator's page: `python -m benchmarks.console [MISSIONS]`; needs Debian's chromium.

With `macta serve` and MISSIONS past missions: the time until the page is usable, cold; how smoothly its lists scroll
while about ten events a second arrive, with a page of fifty and with all; the costs of an idle page. Medians.
"""

import argparse
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median, quantiles
from tempfile import TemporaryDirectory
from typing import Any

import httpx2
from playwright.sync_api import Browser, Page, sync_playwright

from app.planning.pool.process_tree import tree_of
from benchmarks.console.history import Traffic, carry_out, fill
from benchmarks.processes import cpu_s, tree_cpu_s
from tests.chromium import SOFTWARE_GL, chromium
from tests.scenarios.serving import Served, macta_serve

STATIC = Path(__file__).parents[2] / "web" / "static"
WORLD = "sample_store"
LOADS, SCROLL_S, IDLE_S, PACE_S = 9, 10.0, 15.0, 0.15
USABLE = """
  const seen = new MutationObserver(() => {
    if (!document.querySelector("[data-testid=goal-item]")) return;
    seen.disconnect();
    const stand = () => { document.documentElement.dataset.usable = performance.now(); };
    requestAnimationFrame(() => requestAnimationFrame(stand));
  });
  seen.observe(document, { childList: true, subtree: true });
"""
TRANSFERRED = """
  [...performance.getEntriesByType("navigation"), ...performance.getEntriesByType("resource")]
    .filter((one) => !/\\/(v1|viewer)\\//.test(one.name))
    .reduce((sum, one) => [sum[0] + one.transferSize, sum[1] + one.decodedBodySize], [0, 0])
"""
WATCH = """
  window.frames_ = [];
  window.long_ = [];
  const note = (list) => list.getEntries().forEach((one) => window.long_.push(one.duration));
  new PerformanceObserver(note).observe({ type: "longtask" });
  let last = performance.now();
  const pane = document.getElementById("left");
  let down = 9;
  const frame = (now) => {
    window.frames_.push(now - last);
    last = now;
    const before = pane.scrollTop;
    pane.scrollTop += down;
    if (pane.scrollTop === before) down = -down;
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
"""


def load(browser: Browser, served: Served) -> tuple[float, float, float, float]:
    """Seconds from the page's request to its first paint, and until the goals are shown; kB of its files until the
    newest goal's plan and mission are shown, as they came and uncompressed.
    """
    context = browser.new_context(viewport={"width": 1440, "height": 810})
    page = context.new_page()
    page.add_init_script(USABLE)
    page.goto(served.console)
    page.locator("html[data-usable]").wait_for(state="attached")
    painted = "performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? NaN"
    first, usable = page.evaluate(f"[{painted}, Number(document.documentElement.dataset.usable)]")
    page.get_by_test_id("plan").wait_for()
    page.get_by_test_id("mission").wait_for()
    came, uncompressed = page.evaluate(TRANSFERRED)
    context.close()
    return first / 1000, usable / 1000, came / 1000, uncompressed / 1000


def show_all(page: Page) -> None:
    """Load all older entries of both lists."""
    for name in ("#goals", "#missions"):
        while (older := page.locator(f"{name} [data-older]")).count():
            shown = page.locator(f"{name} .item").count()
            older.click()
            page.locator(f"{name} .item").nth(shown).wait_for()


def scroll(page: Page, traffic: Traffic, service: int) -> str:
    """Scroll to and fro while events arrive."""
    page.evaluate(WATCH)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    begun, spent_s = time.monotonic(), cpu_s(service)
    while time.monotonic() - begun < SCROLL_S:
        traffic.cause()
        page.wait_for_timeout(1000 * PACE_S)
    took_s = time.monotonic() - begun
    share = 100 * (cpu_s(service) - spent_s) / took_s
    frames, long = page.evaluate("[window.frames_, window.long_]")
    return (
        f"frames median {median(frames):.0f} ms, p99 {quantiles(frames, n=100)[-1]:.0f}, longest {max(frames):.0f}; "
        f"long tasks {len(long) / took_s:.1f} a second, longest {max(long, default=0):.0f} ms; "
        f"{len(asked) / took_s:.0f} requests a second; service {share:.0f} % of a core"
    )


def idle(page: Page, served: Served) -> str:
    page.wait_for_timeout(3000)
    before = idle_cpu_s(served)
    page.wait_for_timeout(1000 * IDLE_S)
    shares = (100 * (b - a) / IDLE_S for a, b in zip(before, idle_cpu_s(served), strict=True))
    told = zip(("service with world", "view", "page", "its graphics"), shares, strict=True)
    return ", ".join(f"{name} {share:.1f}" for name, share in told) + " % of a core"


def idle_cpu_s(served: Served) -> tuple[float, ...]:
    """Seconds used by service and world, by the view, by browsers' pages and by their software graphics."""
    view, renderer, graphics = (
        sum(cpu_s(one.pid) for one in tree_of(os.getpid()) if mark in command(one.pid))
        for mark in ("web.viewer", "--type=renderer", "--type=gpu-process")
    )
    return tree_cpu_s(served.process.pid) - view, view, renderer, graphics


def command(pid: int) -> str:
    return Path(f"/proc/{pid}/cmdline").read_text()


@contextmanager
def opened(browser: Browser, served: Served, world_as: str) -> Iterator[Page]:
    """The live page, which shows its world as map or view."""
    context = browser.new_context(viewport={"width": 1440, "height": 810})
    page = context.new_page()
    page.add_init_script(f"localStorage.setItem('macta.world-as', JSON.stringify('{world_as}'))")
    page.goto(served.console)
    page.locator("[data-testid=live-badge]", has_text="live").wait_for()
    page.locator("[data-testid=goal-item]").first.wait_for()
    yield page
    context.close()


def measure(browser: Browser, served: Served, api: httpx2.Client) -> None:
    before = tree_cpu_s(served.process.pid), tree_cpu_s(os.getpid())
    painted, usable, came, uncompressed = zip(*(load(browser, served) for _ in range(LOADS)), strict=True)
    spent_s = tree_cpu_s(served.process.pid) - before[0], tree_cpu_s(os.getpid()) - before[1]
    service, browsing = (one / LOADS for one in (spent_s[0], spent_s[1] - spent_s[0]))
    took = f"painted {median(painted):.2f} s, usable {median(usable):.2f} s (longest {max(usable):.2f}), "
    took += f"{median(came):.1f} kB of files came, {median(uncompressed):.1f} kB uncompressed; "
    took += f"CPU {service:.2f} s of the service, {browsing:.2f} s of the browser"
    print(f"cold, {LOADS} times: {took}", flush=True)
    with opened(browser, served, "map") as page:
        print(f"idle, map: {idle(page, served)}", flush=True)
    with opened(browser, served, "view") as page:
        print(f"idle, three dimensions: {idle(page, served)}", flush=True)
    print(f"no page: {idle(browser.new_page(), served)}", flush=True)
    traffic = Traffic(api, WORLD)
    with opened(browser, served, "map") as page:
        print(f"a page of each list: {scroll(page, traffic, served.process.pid)}", flush=True)
    with opened(browser, served, "map") as page:
        show_all(page)
        print(
            f"{page.locator('.item').count()} items: {scroll(page, traffic, served.process.pid)}", flush=True
        )


def main() -> None:
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("missions", type=int, nargs="?", default=500)
    missions: Any = options.parse_args().missions
    size = sum(path.stat().st_size for path in STATIC.rglob("*") if path.is_file())
    print(f"the console's own files: {size / 1000:.1f} kB", flush=True)
    with TemporaryDirectory() as folder, macta_serve(Path(folder)) as served:
        headers = {"authorization": f"Bearer {served.token}"}
        with httpx2.Client(base_url=served.address, headers=headers, timeout=30) as api:
            carry_out(api, "move sample_1 to bay_7")
            fill(Path(folder), missions)
            with sync_playwright() as driver, chromium(driver, *SOFTWARE_GL) as browser:
                measure(browser, served, api)


if __name__ == "__main__":
    main()
