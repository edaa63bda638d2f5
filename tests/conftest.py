"""What tests of every room may ask for."""

import gc
import logging
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.bytecode import keep

keep(Path(__file__).parents[1] / ".pytest_cache" / "bytecode")  # before most is imported

# ruff: noqa: E402
from robots.kernels import install

install()  # before anything that is compiled is imported

from fastapi.dependencies import models
from hypothesis import settings

from app.composition import make_engine
from app.planning.pool.pool import PlanningWorker
from tests import compiled_statements
from tests.databases import SQLITE, fresh

YOUNG_OBJECTS = 200_000
"""So many more objects are made than freed between two collections of garbage; 700 by default. The objects of a running
service outlive its test's collections: with fewer, a tenth of the CPU time of such tests goes to looking at them again.
"""
# Else the workflow engine logs to standard error as it is when it is first made, captured for one test say, and fails
# to flush it in later ones.
logging.getLogger("dbos").addHandler(logging.NullHandler())
logging.getLogger("dbos").propagate = False
compiled_statements.share()
settings.register_profile("macta", deadline=None)  # a loaded machine is no failure
settings.load_profile("macta")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest files first: begun last, they would hold up the end on one worker.

    Those of the page stay last: their browser keeps an event loop running, beside which no service may start.
    """
    items.sort(key=lambda item: "scenarios" not in item.path.parts)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[object]:
    """Collect no garbage while modules are imported, and never what they hold: services make much of it by themselves.

    A collection of what is imported took 0.6 CPU seconds, once in every few services.
    """
    gc.disable()
    found = yield
    gc.freeze()
    gc.set_threshold(YOUNG_OBJECTS)
    gc.enable()
    return found


def pytest_runtest_logfinish() -> None:
    """Have FastAPI forget the routes of a service that has ended, and with them all that they hold.

    It keeps what it knows of functions, by function, as long as the process lives: 26 000 objects a service.
    """
    for kept in vars(models).values():
        if hasattr(kept, "cache_clear"):
            kept.cache_clear()


@pytest.fixture
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """An empty database: SQLite, or what `ON_BOTH` and `ON_POSTGRESQL` of `tests.databases` ask for."""
    with fresh(getattr(request, "param", SQLITE), tmp_path) as url:
        yield url


@pytest.fixture(scope="session")
def worker() -> Iterator[PlanningWorker]:
    """The planning process, warm."""
    worker = PlanningWorker(make_engine)
    worker.warm_up().result(timeout=300)
    yield worker
    worker.close()
