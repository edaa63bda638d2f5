"""Debian's browser for tests: its headless shell, which takes a quarter less CPU time, or else the whole browser."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Playwright

PROGRAM = shutil.which("chromium-headless-shell") or shutil.which("chromium")
FLAGS = [
    "--no-sandbox",
    "--disable-quic",
    "--disable-background-networking",
    "--disable-sync",
]
SOFTWARE_GL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
NEEDED = [
    pytest.mark.browser,
    pytest.mark.skipif(PROGRAM is None, reason="no chromium on this machine: apt-get install chromium"),
]
PATIENCE_MS = 30_000
"""How long a page may take to show what is expected: a loaded machine is no failure, and 5 s, the default, is soon over
while other tests compile and a view is drawn in software."""


@contextmanager
def chromium(driver: "Playwright", *flags: str) -> Iterator["Browser"]:
    """A browser for the length of the block; what tests expect of its pages, they wait for `PATIENCE_MS`."""
    from playwright.sync_api import expect

    expect.set_options(timeout=PATIENCE_MS)
    browser = driver.chromium.launch(executable_path=PROGRAM, args=[*FLAGS, *flags])
    yield browser
    browser.close()
