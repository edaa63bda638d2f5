"""The garbage collector rests while a plan is made, and is what it was before afterwards."""

import gc
from collections.abc import Iterator

import pytest

from planner.engines.garbage_collection import garbage_collection_paused


@pytest.fixture(autouse=True)
def collecting() -> Iterator[None]:
    gc.enable()
    yield
    gc.enable()


def test_it_rests_and_goes_on() -> None:
    with garbage_collection_paused():
        assert not gc.isenabled()
    assert gc.isenabled()


def test_it_goes_on_after_an_error() -> None:
    with pytest.raises(ZeroDivisionError), garbage_collection_paused():
        1 / 0  # noqa: B018
    assert gc.isenabled()


def test_one_that_rested_before_rests_on() -> None:
    gc.disable()
    with garbage_collection_paused():
        pass
    assert not gc.isenabled()
