"""What tests of every room may ask for."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.databases import SQLITE, fresh


@pytest.fixture
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """An empty database: SQLite, or what `ON_BOTH` and `ON_POSTGRESQL` of `tests.databases` ask for."""
    with fresh(getattr(request, "param", SQLITE), tmp_path) as url:
        yield url


@pytest.fixture
def wait_for() -> Callable[[Callable[[], bool]], None]:
    """`wait_for(lambda: …)` looks until it is true, half a minute long."""

    def until(true: Callable[[], bool]) -> None:
        give_up = time.monotonic() + 30
        while not true():
            assert time.monotonic() < give_up, "that never came true"
            time.sleep(0.02)

    return until
