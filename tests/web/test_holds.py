"""What holds keep is listed with their end and what has ceased to be true, and an operator ends that early."""

from collections.abc import Mapping, Sequence

import pytest

from tests.web.fake_service import FakeService

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Page, expect  # noqa: E402


def hold(name: str, words: str, *, ends: str, lost: Sequence[Mapping[str, object]] = ()) -> dict[str, object]:
    return {
        "id": name,
        "world": "sample_store",
        "words": words,
        "lost": list(lost),
        "ends": ends,
        "text": f"keep {words}",
    }


def test_what_is_kept_is_listed_until_it_is_ended(page: Page, service: FakeService) -> None:
    holds = page.get_by_test_id("holds")
    expect(holds).to_have_count(0)
    service.holds = [
        hold("hold-1", "bay_3 and bay_4 empty", ends="until 2026-03-01 14:30 UTC"),
        hold("hold-2", "bay_7 empty", ends="until an operator ends it"),
    ]
    service.publish("hold.began", "hold-2")
    expect(holds).to_contain_text("Kept (2)")
    expect(holds).to_contain_text("bay_3 and bay_4 empty until 2026-03-01 14:30 UTC")
    page.get_by_role("button", name="End keeping bay_7 empty").click()
    expect(holds).to_contain_text("Kept (1)")
    assert [one["id"] for one in service.holds] == ["hold-1"]
    page.get_by_test_id("hold-end").click()
    expect(holds).to_have_count(0)


def test_what_has_ceased_to_be_true_is_told_with_what_is_done_about_it(
    page: Page, service: FakeService
) -> None:
    lost = {"now": "sample_2 is in bay_3", "goal": "goal-7", "reason": ""}
    gone = {"now": "sample_4 is in an unknown place", "goal": None, "reason": "it is not known where it is"}
    service.holds = [
        hold("hold-1", "sample_2 in bay_2", ends="until an operator ends it", lost=[lost]),
        hold("hold-2", "sample_4 in bay_11", ends="until an operator ends it", lost=[gone]),
    ]
    service.publish("hold.fact_lost", "hold-1")
    told = page.get_by_test_id("hold-lost")
    expect(told).to_have_count(2)
    expect(told.first).to_have_text("No longer true: sample_2 is in bay_3; goal-7 is to bring it about again")
    expect(told.last).to_contain_text("no goal brings it about again: it is not known where it is")
