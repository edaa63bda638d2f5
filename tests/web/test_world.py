"""The console's right pane: robots, one of them closely, and the map."""

import re

import pytest

from app.domain.world_model.edits import changed
from robots.world import Zone, ZoneRule
from tests.waiting import until
from tests.web.fake_service import WORLD, FakeService
from tests.web.page_controls import hold_first

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Page, expect  # noqa: E402

pytestmark = pytest.mark.browser
TWO_POINTS = re.compile(r"^\S+ \S+$")


@pytest.fixture
def map_of(page: Page) -> Page:
    page.get_by_role("button", name="Map").click()
    expect(page.locator(".sample-mark")).to_have_count(4)
    return page


def test_zones_are_drawn_with_their_names_and_rules(page: Page, service: FakeService) -> None:
    zones = (
        Zone(name="gate", x=(3, 5), y=(0, 3), rule=ZoneRule.ONE_ROBOT),
        Zone(name="north", x=(0, 8), y=(6, 9)),
        Zone(name="yard_end", x=(6, 8), y=(0, 3), rule=ZoneRule.SLOW, max_speed_m_s=0.2),
    )
    service.world = changed(service.world, zones=zones)
    page.reload()
    page.get_by_role("button", name="Map").click()
    expect(page.locator(".zone.one_robot[data-name=gate]")).to_contain_text("gate: one robot")
    expect(page.locator(".zone.named[data-name=north]")).to_have_text("north")
    expect(page.locator(".zone.slow[data-name=yard_end]")).to_have_text("yard_end: at most 0.2 m/s")


def test_a_robot_looked_at_shows_its_synthesis_as_it_goes(page: Page, service: FakeService) -> None:
    service.telemetry["yard_1"] |= {
        "packet_tag": "TRANSPORT",
        "packet_state": "running",
        "holding": "sample_1",
        "patterns": {"rotate/attract": (0.3, 0.8), "rotate/obstacle_avoid": (-0.4, 0.25)},
        "resultants": {"rotate": (0.12, 0.5)},
    }
    page.get_by_test_id("robot").filter(has_text="yard_1").click()
    panel = page.get_by_test_id("robot-panel")
    expect(panel).to_contain_text("TRANSPORT running")
    expect(panel.get_by_label("utility 0.80")).to_be_attached()
    expect(panel).to_contain_text("obstacle avoid")
    service.telemetry["yard_1"]["patterns"] = {"rotate/attract": (0.3, 0.1)}
    expect(panel.get_by_label("utility 0.10")).to_be_attached()
    expect(panel).not_to_contain_text("obstacle avoid")
    panel.get_by_role("button", name="Close").click()
    expect(panel).to_be_hidden()


def test_the_numbers_of_the_world_are_fetched_while_they_are_open(map_of: Page, service: FakeService) -> None:
    def tell(value: float) -> None:
        text = f"yard_1's battery is at {100 * value:g} %"
        told = {"quantity": "battery", "args": ["yard_1"], "value": value, "text": text}
        service.numbers = [told | {"source": "report of yard_1", "at_s": 12.0}]
        service.numbers_version += 1

    tell(0.8)
    page = map_of
    page.get_by_text("Numbers", exact=True).click()
    numbers = page.get_by_test_id("numbers")
    expect(numbers).to_contain_text("battery(yard_1)")
    expect(numbers).to_contain_text("yard_1's battery is at 80 % · report of yard_1 at 12.0 s")
    tell(0.75)
    expect(numbers).to_contain_text("75 %")
    page.get_by_text("Numbers", exact=True).click()
    asked = service.asked_numbers
    tell(0.7)
    service.publish("world.facts_changed", WORLD)
    expect(numbers).to_be_hidden()
    page.get_by_text("Numbers", exact=True).click()
    expect(numbers).to_contain_text("70 %")
    assert service.asked_numbers == asked + 1


def test_a_robot_that_is_silent_can_be_declared_lost(page: Page, service: FakeService) -> None:
    service.connection["yard_2"] = "offline"
    service.publish("robot.offline", "yard_2")
    page.get_by_test_id("robot").filter(has_text="yard_2").click()
    expect(page.get_by_test_id("robot-connection")).to_have_text("offline")
    page.get_by_test_id("robot-declare_lost").click()
    expect(page.get_by_test_id("robot-connection")).to_have_text("lost")
    page.get_by_test_id("robot-declare_found").click()
    expect(page.get_by_test_id("robot-connection")).to_have_text("offline")
    assert service.declared == [("yard_2", "declare_lost"), ("yard_2", "declare_found")]


def test_a_robot_is_taken_out_of_service_with_a_reason_and_brought_back(
    page: Page, service: FakeService
) -> None:
    line = page.get_by_test_id("robot").filter(has_text="yard_2")
    line.click()
    panel = page.get_by_test_id("robot-panel")
    panel.get_by_text("Take out of service").click()
    panel.get_by_test_id("robot-take_out_of_service").click()  # without a reason the form is not sent
    panel.get_by_test_id("robot-service-reason").fill("its left wheel slips")
    panel.get_by_test_id("robot-take_out_of_service").click()
    expect(panel).to_contain_text("its left wheel slips (administrator)")
    expect(line).to_contain_text("out of service")
    assert service.out_of_service == {"yard_2": "its left wheel slips"}
    panel.get_by_test_id("robot-bring_back").click()
    expect(panel.get_by_text("Take out of service")).to_be_visible()
    expect(line).not_to_contain_text("out of service")


def test_a_sample_and_a_place_picked_on_the_map_become_a_goal(map_of: Page, service: FakeService) -> None:
    map_of.locator("[data-name=bay_6] rect").click()
    expect(map_of.locator("#pick-note")).to_contain_text("Pick a sample first")
    service.connection["yard_2"] = "offline"
    service.publish("robot.offline", "yard_2")
    expect(map_of.get_by_role("button", name="out of contact yard_2")).to_be_visible()
    expect(map_of.locator("#pick-note")).to_contain_text("Pick a sample first")  # other changes leave it
    map_of.locator("[data-name=sample_2] rect").click()
    map_of.locator("[data-name=bay_6] rect").click()
    expect(map_of.get_by_test_id("goal-text")).to_have_value("move sample_2 to bay_6")
    expect(map_of.get_by_test_id("goal-hint")).to_have_text("understood: in(sample_2, bay_6)")


def test_robots_move_on_the_map_and_are_looked_at_from_it(map_of: Page, service: FakeService) -> None:
    mark = map_of.locator(".robot-mark[data-robot=yard_1]")
    expect(mark).to_be_visible()
    before = mark.bounding_box()
    service.telemetry["yard_1"]["y_m"] += 1.0
    expect(map_of.locator(".trail").first).to_have_attribute("points", TWO_POINTS)
    after = mark.bounding_box()
    assert before is not None
    assert after is not None
    assert after["y"] < before["y"]  # north is up
    mark.locator("circle").click()
    expect(map_of.get_by_test_id("robot-panel")).to_contain_text("yard_1")


def test_a_robot_on_the_map_keeps_the_focus_while_it_moves(page: Page, service: FakeService) -> None:
    page.get_by_role("button", name="Map").click()
    mark = page.locator(".robot-mark[data-robot=yard_1]")
    expect(mark).to_be_visible()
    mark.focus()
    service.telemetry["yard_1"]["x_m"] = 7.5
    expect(mark.locator("> g")).to_have_attribute("transform", "translate(7.5 -1.8) rotate(0)")
    expect(mark).to_be_focused()


def test_the_first_world_of_the_list_is_shown_first(page: Page, service: FakeService) -> None:
    service.worlds = ["yonder", WORLD]
    page.reload()
    expect(page.locator("#world")).to_have_value("yonder")


def test_worlds_come_and_go_while_the_page_is_open(page: Page, service: FakeService) -> None:
    choice = page.locator("#world")
    service.worlds.append("yonder")
    service.starting.add("yonder")
    service.publish("world.added", "yonder")
    expect(choice.locator("option")).to_have_text([service.world.title, "yonder (starting)"])
    choice.select_option("yonder")
    service.worlds.remove("yonder")
    service.publish("world.removed", "yonder")
    expect(choice).to_have_value(WORLD)
    expect(choice.locator("option")).to_have_count(1)


def test_a_robot_and_a_sample_looked_at_are_left_with_their_world(map_of: Page, service: FakeService) -> None:
    service.worlds.append("yonder")
    choice, panel = map_of.locator("#world"), map_of.get_by_test_id("robot-panel")
    map_of.locator(".robot-mark[data-robot=yard_1] circle").click()
    expect(panel).to_be_visible()  # before it is, it may move the map under the next click
    map_of.locator("[data-name=sample_2] rect").click()
    expect(map_of.locator(".picked")).to_have_count(1)
    choice.select_option("yonder")
    expect(panel).to_be_hidden()
    choice.select_option(WORLD)
    expect(map_of.locator(".robot-mark")).to_have_count(4)
    expect(panel).to_be_hidden()
    expect(map_of.locator(".picked")).to_have_count(0)


def test_the_map_shows_the_samples_as_they_were_asked_for_last(map_of: Page, service: FakeService) -> None:
    mark = map_of.locator(".sample-mark[data-name=sample_1] rect")

    def place() -> list[str | None]:
        return [mark.get_attribute("x"), mark.get_attribute("y")]

    def move(bay: str) -> None:
        service.facts[0]["args"] = ["sample_1", bay]
        service.version += 1

    start, held = place(), hold_first(map_of, "**/facts")
    move("bay_1")
    held.wait()
    assert place() == start
    move("bay_5")
    until(lambda: map_of.wait_for_timeout(50) or place() != start)
    last = place()
    held.hand_over()
    assert place() == last


@pytest.fixture
def guarded(page: Page, service: FakeService) -> Page:
    """The map of a world with doors, a hatch and a lift."""
    service.show_world("guarded_store")
    page.reload()
    page.get_by_role("button", name="Map").click()
    expect(page.locator(".peripheral-mark")).to_have_count(4)
    return page


def test_doors_and_lifts_are_on_the_map_as_they_stand(guarded: Page, service: FakeService) -> None:
    gate = guarded.locator(".peripheral-mark[data-robot=gate_1]")
    lift = guarded.locator(".peripheral-mark[data-robot=lift_1]")
    expect(gate).to_have_attribute("aria-label", "door gate_1: closed")
    expect(gate.locator(".leaf")).to_have_css("display", "inline")
    expect(lift).to_have_attribute("aria-label", "lift lift_1: at ground")
    expect(guarded.locator(".robot-mark")).to_have_count(3)  # a door is drawn as no robot
    service.telemetry["gate_1"] |= {"packet_tag": "OPEN", "packet_state": "running"}
    expect(gate.locator(".panel.moving")).to_have_count(1)
    expect(gate.locator("text")).to_have_text("gate_1: opening")
    service.telemetry["gate_1"] |= {"packet_tag": None, "packet_state": None}
    service.states |= {"gate_1": "opened", "lift_1": "upper"}
    service.version += 1
    expect(gate).to_have_attribute("aria-label", "door gate_1: open")
    expect(gate.locator(".leaf")).to_have_css("display", "none")
    expect(lift.locator(".panel.open")).to_have_count(1)
    expect(lift.locator(".panel").nth(1)).to_have_class("panel open")


def test_a_door_out_of_service_says_why_and_is_brought_back(guarded: Page, service: FakeService) -> None:
    service.out_of_service["gate_2"] = "it is stuck half-way"
    service.states["gate_2"] = ""
    service.publish("world.changed", WORLD)
    gate = guarded.locator(".peripheral-mark[data-robot=gate_2]")
    said = "door gate_2: state unknown, out of service, it is stuck half-way"
    expect(gate).to_have_attribute("aria-label", said)
    expect(gate.locator(".cross")).to_be_visible()
    line = guarded.get_by_test_id("robot").filter(has_text="gate_2")
    expect(line).to_contain_text("out of service, door, state unknown")
    gate.focus()
    gate.press("Enter")
    panel = guarded.get_by_test_id("robot-panel")
    expect(panel.get_by_test_id("standing")).to_have_text("door, state unknown")
    expect(panel.get_by_role("button", name="Drive")).to_have_count(0)
    panel.get_by_test_id("robot-bring_back").click()
    expect(gate).not_to_have_class(re.compile("faulty"))
    expect(line).not_to_contain_text("out of service")


CROSSED_NAMES = """() => {
  const walls = [...document.querySelectorAll(".map-drawing :is(.wall, .opening)")];
  const names = [...document.querySelectorAll(".place-mark text")];
  const isCrossed = (name) => walls.some((wall) => {
    const [one, other] = [name.getBoundingClientRect(), wall.getBoundingClientRect()];
    const isBeside = one.right < other.left || other.right < one.left;
    return !isBeside && one.top < other.bottom && other.top < one.bottom;
  });
  return [names.length, names.filter(isCrossed).map((name) => name.textContent)];
}"""
"""How many places are named on the map, and the names that a wall or an opening lies across."""


@pytest.mark.parametrize("width", [1440, 1024, 420])
def test_no_door_or_wall_covers_a_places_name(page: Page, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 900})
    page.get_by_role("button", name="Map").click()
    expect(page.locator(".place-mark").first).to_be_visible()
    count, crossed = page.evaluate(CROSSED_NAMES)
    assert count == 16
    assert crossed == []
