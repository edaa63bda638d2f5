"""Places that are kept empty are listed with their end, and an operator ends that early."""

import pytest

from tests.web.fake_service import FakeService

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Page, expect  # noqa: E402


def hold(name: str, *places: str, ends: str) -> dict[str, object]:
    return {
        "id": name,
        "world": "sample_store",
        "places": list(places),
        "ends": ends,
        "text": f"keep {places}",
    }


def test_what_is_kept_empty_is_listed_until_it_is_ended(page: Page, service: FakeService) -> None:
    holds = page.get_by_test_id("holds")
    expect(holds).to_have_count(0)
    service.holds = [
        hold("hold-1", "bay_3", "bay_4", ends="until 2026-03-01 14:30 UTC"),
        hold("hold-2", "bay_7", ends="until an operator ends it"),
    ]
    service.publish("hold.began", "hold-2")
    expect(holds).to_contain_text("Kept empty (2)")
    expect(holds).to_contain_text("bay_3, bay_4 until 2026-03-01 14:30 UTC")
    page.get_by_role("button", name="End keeping bay_7 empty").click()
    expect(holds).to_contain_text("Kept empty (1)")
    assert [one["id"] for one in service.holds] == ["hold-1"]
    page.get_by_test_id("hold-end").click()
    expect(holds).to_have_count(0)
