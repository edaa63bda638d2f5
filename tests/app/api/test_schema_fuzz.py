"""Requests made from the API's own reference, right ones and wrong ones, are answered as the reference says."""

import pytest

from app.composition import Service
from benchmarks.request_fuzz import fuzz
from tests.app.conftest import TOKEN


# schemathesis draws from `random` in its strategies and shows long bodies; hypothesis warns of both.
@pytest.mark.filterwarnings("ignore::hypothesis.errors.HypothesisWarning")
def test_every_answer_is_as_the_reference_says_and_none_is_500(shared_service: Service) -> None:
    shared_service.stopping.set()  # streams end after the present state
    fuzzed = fuzz(shared_service.api, TOKEN, examples=1, seed=1, stateful=False)
    assert not fuzzed.findings, "\n".join(f"{name}: {example}" for name, example in fuzzed.findings.items())
    assert fuzzed.requests > 500
    assert {200, 202, 404, 405, 422} <= fuzzed.statuses.keys()
    assert not [status for status in fuzzed.statuses if status >= 500]
