"""The world is edited on its map: what is dragged, picked and added is a draft until it is made with a reason."""

from typing import TYPE_CHECKING

import pytest

from tests.chromium import NEEDED
from tests.web.fake_service import FakeService
from tests.web.page_controls import hold_first

if TYPE_CHECKING:
    from playwright.sync_api import Page

pytestmark = NEEDED


@pytest.fixture
def editing(page: "Page") -> "Page":
    """The console with the editor open."""
    page.locator("#as-map").click()
    page.get_by_test_id("edit-world").click()
    page.get_by_label("Place of the new sample").locator("option").first.wait_for(state="attached")
    return page


def test_an_older_objection_is_not_shown_once_its_change_is_left_out(
    editing: "Page", service: FakeService
) -> None:
    held = hold_first(editing, "**/changes:check")
    editing.get_by_label("Name of the new sample").fill("sample_9")
    editing.get_by_label("Place of the new sample").select_option("door_1")
    editing.get_by_test_id("edit-add").click()
    held.wait()
    editing.get_by_label("Leave out: add sample sample_9 at door_1").click()
    held.hand_over()
    assert editing.get_by_test_id("edit-problem").inner_text() == ""


def test_a_place_is_dragged_a_sample_added_and_one_removed_together(
    editing: "Page", service: FakeService
) -> None:
    from playwright.sync_api import expect

    name = editing.get_by_label("Name of the new sample")
    name.fill("sample_9")
    editing.get_by_label("Place of the new sample").select_option("door_1")
    editing.get_by_test_id("edit-add").click()
    expect(editing.get_by_test_id("edit-problem")).to_contain_text("door_1 is taken")
    editing.get_by_label("Leave out: add sample sample_9 at door_1").click()
    expect(editing.get_by_test_id("edit-problem")).to_be_empty()
    name.fill("sample_9")
    editing.get_by_label("Place of the new sample").select_option("bay_1")
    editing.get_by_test_id("edit-add").click()

    mark = editing.locator(".place-mark[data-name=bay_7] rect")
    before = mark.bounding_box()
    assert before is not None
    x, y = before["x"] + before["width"] / 2, before["y"] + before["height"] / 2
    editing.mouse.move(x, y)
    editing.mouse.down()
    editing.mouse.move(x, y + before["height"], steps=4)  # a place is drawn 0.48 m high
    editing.mouse.up()
    editing.locator(".sample-mark[data-name=sample_1] rect").click()
    expect(editing.get_by_test_id("edits").locator("li")).to_have_count(3)
    editing.get_by_test_id("edit-reason").fill("a delivery")
    editing.get_by_test_id("edit-make").click()
    expect(editing.get_by_test_id("edits").locator("li")).to_have_count(0)
    expect(editing.get_by_test_id("changes")).to_contain_text("remove sample sample_1")

    (made,) = service.changes
    added, moved, removed = made["edits"]
    assert made["reason"] == "a delivery"
    assert added == {"edit": "add_sample", "sample": {"name": "sample_9", "at": "bay_1"}}
    assert (moved["edit"], moved["name"]) == ("move_place", "bay_7")
    assert moved["at"] == pytest.approx([4.5, 5.2 - 0.48], abs=0.05)
    assert removed == {"edit": "remove_sample", "name": "sample_1"}


def test_a_zone_that_is_drawn_is_made_with_the_chosen_rule(editing: "Page", service: FakeService) -> None:
    from playwright.sync_api import expect

    def corner(place: str) -> tuple[float, float]:
        box = editing.locator(f".place-mark[data-name={place}] rect").bounding_box()
        assert box is not None
        return box["x"] + 1.5 * box["width"], box["y"] + box["height"] / 2

    editing.get_by_label("Name of the next zone").fill("loading_bay")
    editing.get_by_label("Rule of the next zone").select_option("slow")
    editing.get_by_label("Speed in the next zone, m/s").fill("0.25")
    editing.mouse.move(*corner("bay_7"))  # its mark is 0.48 m wide
    editing.mouse.down()
    editing.mouse.move(*corner("bay_8"))
    x, y = corner("bay_8")
    editing.mouse.move(x + 40, y, steps=3)
    editing.mouse.up()
    expect(editing.get_by_test_id("edits")).to_contain_text("add zone loading_bay: at most 0.25 m/s")
    editing.get_by_test_id("edit-reason").fill("a spill")
    editing.get_by_test_id("edit-make").click()
    expect(editing.get_by_test_id("changes")).to_contain_text("add zone loading_bay")
    (made,) = service.changes[0]["edits"]
    assert made["edit"] == "add_zone"
    assert (made["zone"]["rule"], made["zone"]["max_speed_m_s"]) == ("slow", 0.25)
    assert made["zone"]["y"] == pytest.approx([5.2, 6.6], abs=0.1)
    assert made["zone"]["x"][0] == pytest.approx(4.5 + 0.48, abs=0.1)


def test_a_change_is_undone_once(editing: "Page", service: FakeService) -> None:
    from playwright.sync_api import expect

    editing.locator(".sample-mark[data-name=sample_1] rect").click()
    editing.get_by_test_id("edit-reason").fill("it broke")
    editing.get_by_test_id("edit-make").click()
    editing.get_by_test_id("undo-1").click()
    expect(editing.get_by_test_id("changes")).to_contain_text("undone by 2")
    expect(editing.get_by_test_id("undo-1")).to_have_count(0)
    assert [change["edition"] for change in service.changes] == [2, 1]


def test_what_is_picked_makes_a_goal_again_once_the_editor_is_closed(editing: "Page") -> None:
    from playwright.sync_api import expect

    editing.get_by_test_id("edit-world").click()
    editing.locator(".sample-mark[data-name=sample_1] rect").click()
    expect(editing.locator("#pick-note")).to_contain_text("sample_1")
    expect(editing.get_by_test_id("editor")).to_be_hidden()


def test_speed_and_packets_of_a_robot_that_is_picked_are_changed(
    editing: "Page", service: FakeService
) -> None:
    from playwright.sync_api import expect

    editing.locator(".robot-mark[data-robot=yard_2]").click()
    expect(editing.get_by_test_id("edit-robot")).to_have_value("yard_2")
    speed = editing.get_by_label("Speed in metres a second")
    expect(speed).to_have_value("0.5")
    editing.get_by_test_id("edit-change-robot").click()  # nothing is otherwise
    expect(editing.get_by_test_id("edits").locator("li")).to_have_count(0)
    speed.fill("0.2")
    editing.get_by_label("Packets, separated by spaces").fill("NAVIGATE  DOCK")
    editing.get_by_test_id("edit-change-robot").click()
    expect(editing.get_by_test_id("edits")).to_contain_text("change robot yard_2: speed_m_s, repertoire")
    editing.get_by_test_id("edit-reason").fill("a worn wheel")
    editing.get_by_test_id("edit-make").click()
    expect(editing.get_by_test_id("changes")).to_contain_text("change robot yard_2")
    (made,) = service.changes[0]["edits"]
    assert made == {
        "edit": "change_robot",
        "name": "yard_2",
        "speed_m_s": 0.2,
        "repertoire": ["NAVIGATE", "DOCK"],
    }


@pytest.mark.parametrize("is_external", [False, True])
def test_a_robot_is_replaced_by_its_own_software_and_its_twin_by_the_robot(
    page: "Page", service: FakeService, is_external: bool
) -> None:
    from playwright.sync_api import expect

    robots = [
        one.model_copy(update={"external": is_external and one.name == "yard_2"})
        for one in service.world.robots
    ]
    service.world = service.world.model_copy(update={"robots": tuple(robots)})
    page.locator("#as-map").click()
    page.get_by_test_id("edit-world").click()
    page.get_by_test_id("edit-robot").select_option("yard_2")
    speaker = page.get_by_test_id("edit-speaker")
    expect(speaker).to_have_value("external" if is_external else "")
    speaker.select_option("" if is_external else "external")
    page.get_by_test_id("edit-change-robot").click()
    expect(page.get_by_test_id("edits")).to_contain_text("change robot yard_2: external")
    page.get_by_test_id("edit-reason").fill("its motor")
    page.get_by_test_id("edit-make").click()
    expect(page.get_by_test_id("edits").locator("li")).to_have_count(0)
    edits = service.changes[0]["edits"]
    assert edits == [{"edit": "change_robot", "name": "yard_2", "external": not is_external}]


def test_robots_that_have_announced_themselves_are_admitted_or_refused(
    page: "Page", service: FakeService
) -> None:
    from playwright.sync_api import expect

    for robot in ("visitor_1", "visitor_2", "gate_1"):
        service.announce(robot)
    page.locator("#as-map").click()
    page.get_by_test_id("edit-world").click()
    listed = page.get_by_test_id("announced")
    expect(listed.locator("li")).to_have_count(3)
    expect(listed).to_contain_text("visitor_1 NAVIGATE · 0.4 m/s")
    page.get_by_test_id("admit-visitor_1").click()
    expect(listed.locator("li")).to_have_count(2)
    page.get_by_test_id("refuse-visitor_2").click()
    expect(listed).to_contain_text("refused: refused on the page")
    page.get_by_test_id("admit-gate_1").click()
    expect(page.get_by_test_id("edit-problem")).to_contain_text("the name gate_1 is in use")
    assert [one["state"] for one in service.factsheets] == ["in_force", "refused", "announced"]


def test_the_map_stays_large_enough_to_draw_on_beside_what_is_open(
    editing: "Page", service: FakeService
) -> None:
    number = {
        "quantity": "load",
        "value": 0.0,
        "unit": "",
        "text": "",
        "counted": True,
        "source": "",
        "at_s": 0.0,
    }
    service.numbers = [number | {"args": [f"robot_{index}"]} for index in range(30)]
    editing.set_viewport_size({"width": 390, "height": 844})
    editing.locator(".numbers summary").click()
    editing.locator(".numbers dt").last.wait_for()
    box = editing.locator(".map-drawing").bounding_box()
    assert box is not None
    assert box["height"] > 140
