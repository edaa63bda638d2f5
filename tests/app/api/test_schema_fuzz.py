"""Requests made from the API's own reference, right ones and wrong ones, are answered as the reference says."""

from collections.abc import Callable
from functools import cache

import pytest

from app.composition import Service
from benchmarks.request_fuzz import Fuzzed, fuzz
from tests.app.conftest import TOKEN

PARTS = 32
"""Of the API's paths, each asked for once by a test of its own."""
Ask = Callable[[int], Fuzzed]

# schemathesis draws from `random` in its strategies and shows long bodies; hypothesis warns of both.
pytestmark = pytest.mark.filterwarnings("ignore::hypothesis.errors.HypothesisWarning")


@pytest.fixture(scope="module")
def ask(shared_service: Service) -> Ask:
    """Answers what a part of the paths was answered."""
    shared_service.stopping.set()  # streams end after the present state
    paths = sorted(shared_service.api.openapi()["paths"])

    def part(number: int) -> Fuzzed:
        asked = paths[number::PARTS]
        return fuzz(shared_service.api, TOKEN, examples=1, seed=1, stateful=False, paths=asked)

    return cache(part)


@pytest.mark.parametrize("number", range(PARTS))
def test_every_answer_is_as_the_reference_says_and_none_is_500(ask: Ask, number: int) -> None:
    fuzzed = ask(number)
    assert not fuzzed.findings, "\n".join(f"{name}: {example}" for name, example in fuzzed.findings.items())
    assert not [status for status in fuzzed.statuses if status >= 500]
    assert 405 in fuzzed.statuses


def test_the_requests_are_right_ones_and_wrong_ones(ask: Ask) -> None:
    parts = [ask(number) for number in range(PARTS)]
    assert sum(part.requests for part in parts) > 500
    assert {200, 202, 404, 405, 422} <= set().union(*(part.statuses for part in parts))
