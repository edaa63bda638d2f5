"""The workbench: robots found and described, and one of them driven by hand, with a dead man's handle."""

from typing import Any

import pytest

from tests.waiting import until
from tests.web.fake_service import FakeService
from tests.web.page_controls import hold_first

playwright = pytest.importorskip("playwright.sync_api")
from playwright.sync_api import Locator, Page, expect  # noqa: E402

pytestmark = pytest.mark.browser


def opened(page: Page, part: str) -> Locator:
    """A part of the workbench with yard_1 in it."""
    page.locator("[data-testid=robot][data-robot=yard_1]").click()
    page.locator("#workbench-toggle").click()
    page.get_by_test_id(f"bench-{part}").click()
    return page.get_by_test_id("workbench")


def take(page: Page, service: FakeService) -> Locator:
    """The state line of a drive that has begun."""
    opened(page, "drive")
    page.get_by_test_id("drive-take").click()
    state = page.get_by_test_id("drive-state")
    expect(state).to_have_text("You drive yard_1.")
    return state


def last_wish(service: FakeService) -> tuple[float, float]:
    body = service.set_points[-1][1]
    return round(body["speed_m_s"], 2), round(body["turn_rad_s"], 2)


def test_the_workbench_comes_and_goes_in_place_of_goal_and_plan(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    expect(page.get_by_test_id("plan")).to_be_visible()
    bench = opened(page, "robots")
    expect(bench).to_be_visible()
    expect(page.get_by_test_id("plan")).to_be_hidden()
    page.locator("#workbench-toggle").click()
    expect(bench).to_be_hidden()
    expect(page.get_by_test_id("plan")).to_be_visible()


def test_robots_are_found_by_what_is_said_of_them(page: Page, service: FakeService) -> None:
    bench = opened(page, "robots")
    rows = bench.locator("tbody tr")
    expect(rows).to_have_count(4)
    service.connection["store_1"] = "offline"
    service.publish("robot.quiet", "store_1")
    page.get_by_test_id("bench-search").fill("out of contact")
    expect(rows).to_have_count(1)
    expect(rows).to_contain_text("store_1")
    expect(page.get_by_test_id("bench-changes")).to_have_text("12.0 s: store_1 is out of contact")
    page.get_by_test_id("bench-search").fill("yard velocity")
    expect(rows).to_have_count(2)
    rows.get_by_role("button", name="yard_2").click()
    about = page.get_by_test_id("bench-properties")
    for told in ("home_yard_2", "kind velocity", "16", "version 0", "door_1, interchange_1"):
        expect(about).to_contain_text(told)


def test_robots_that_come_and_go_are_told_without_a_reload(page: Page, service: FakeService) -> None:
    bench = opened(page, "robots")
    expect(bench.locator("tbody tr")).to_have_count(4)
    service.announce("rover_9")
    service.publish("robot.announced", "rover_9", world="sample_store")
    expect(page.get_by_test_id("bench-arrivals")).to_contain_text(
        "announced rover_9 in sample_store since 12.0 s: no world has it. It can NAVIGATE"
    )
    service.factsheets.clear()
    service.telemetry["rover_9"] = service.telemetry["yard_1"]
    service.publish("robot.admitted", "rover_9", world="sample_store")
    service.publish("world.changed", "sample_store")
    expect(page.get_by_test_id("bench-changes")).to_have_text(
        "12.0 s: rover_9 has come and can NAVIGATE, DOCK"
    )
    expect(page.get_by_test_id("bench-arrivals")).to_be_empty()
    del service.telemetry["rover_9"]
    service.publish("world.changed", "sample_store")
    expect(page.get_by_test_id("bench-changes")).to_contain_text("rover_9 is gone; 12.0 s: rover_9 has come")
    expect(bench.locator("tbody tr")).to_have_count(4)


def test_an_older_list_of_robots_that_announced_themselves_replaces_no_newer_one(
    page: Page, service: FakeService
) -> None:
    bench = opened(page, "robots")
    expect(bench.locator("tbody tr")).to_have_count(4)
    held = hold_first(page, "**/factsheets")
    service.publish("robot.announced", "rover_8", world="sample_store")  # which is gone again
    held.wait()
    service.announce("rover_9")
    service.publish("robot.announced", "rover_9", world="sample_store")
    arrivals = page.get_by_test_id("bench-arrivals")
    expect(arrivals).to_contain_text("rover_9")
    held.hand_over()
    assert "rover_9" in arrivals.inner_text()


def test_keys_drive_while_the_pad_has_the_focus(page: Page, service: FakeService) -> None:
    take(page, service)
    page.keyboard.down("ArrowUp")
    until(lambda: last_wish(service) == (0.21, 0.0), "ahead at the medium speed")
    page.keyboard.down("a")
    until(lambda: last_wish(service) == (0.21, 0.7), "ahead and to the left")
    page.keyboard.up("a")
    page.keyboard.up("ArrowUp")
    until(lambda: last_wish(service) == (0.0, 0.0), "nothing is held")
    page.keyboard.down("ArrowUp")
    until(lambda: last_wish(service) == (0.21, 0.0), "ahead again")
    page.get_by_test_id("bench-robot").focus()
    until(lambda: last_wish(service) == (0.0, 0.0), "the pad has lost the focus")
    page.keyboard.press("w")
    page.wait_for_timeout(300)
    assert last_wish(service) == (0.0, 0.0)


def test_buttons_drive_while_they_are_held(page: Page, service: FakeService) -> None:
    take(page, service)
    page.get_by_label("Speed").select_option("full")
    page.get_by_role("button", name="back").hover()
    page.mouse.down()
    until(lambda: last_wish(service) == (-0.3, 0.0), "back at full speed")
    page.mouse.move(5, 5)
    page.mouse.up()
    until(lambda: last_wish(service) == (0.0, 0.0), "released, wherever")


@pytest.mark.parametrize(
    ("does", "told"),
    [
        ("document.querySelector('[data-testid=drive-stop]').click()", "Stopped."),
        ("document.querySelector('[data-testid=drive-take]').click()", "Released."),
        ("dispatchEvent(new Event('blur'))", "Stopped: the page lost the focus."),
        ("document.querySelector('[data-robot=store_1]').click()", "Released: another robot was chosen."),
    ],
)
def test_whatever_takes_the_operator_away_lets_go(
    page: Page, service: FakeService, does: str, told: str
) -> None:
    state = take(page, service)
    page.evaluate(does)
    expect(state).to_have_text(told)
    until(lambda: service.released, "the robot is never released")
    assert service.released == [("yard_1", service.set_points[0][1]["session"])]
    count = len(service.set_points)
    page.wait_for_timeout(600)
    assert len(service.set_points) == count
    page.get_by_test_id("drive-take").click()
    until(lambda: len(service.set_points) > count, "control is never taken again")
    assert service.set_points[-1][1]["session"] != service.set_points[0][1]["session"]


def test_why_a_robot_cannot_be_driven_is_reported(page: Page, service: FakeService) -> None:
    state = take(page, service)
    service.undrivable["yard_1"] = "yard_1 is on mission mission-7"
    expect(state).to_have_text("Stopped: yard_1 is on mission mission-7.")
    expect(page.get_by_test_id("drive-stop")).to_be_disabled()


def test_a_robot_that_is_not_heard_is_said_to_stop_by_itself(page: Page, service: FakeService) -> None:
    state = take(page, service)
    service.last_heard_s = 2.4
    expect(state).to_have_text("No message from yard_1 for 2.4 s: it stops by itself.")


def test_leaving_the_part_lets_go(page: Page, service: FakeService) -> None:
    take(page, service)
    page.get_by_test_id("bench-robots").click()
    until(lambda: service.released, "the robot is never released")


@pytest.mark.parametrize("width", [800, 1024])
def test_all_of_the_workbench_is_within_reach_on_a_narrow_page(page: Page, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 900})
    opened(page, "robots")
    for part in ("robots", "drive", "plots", "behaviour", "mind", "messages"):
        page.get_by_test_id(f"bench-{part}").click()
        wide = page.evaluate(
            "[...document.querySelectorAll('#middle')].map((one) => one.scrollWidth - one.clientWidth)"
        )
        assert wide == [0], part


def test_the_workbench_is_fetched_when_it_is_opened(page: Page) -> None:
    fetched: list[Any] = page.evaluate("performance.getEntriesByType('resource').map((one) => one.name)")
    assert not [name for name in fetched if "workbench/" in name and "lazy" not in name]


def drives(service: FakeService, robot: str, speed_m_s: float) -> None:
    """One more word of a robot, 0.1 s on."""
    told = service.telemetry[robot]
    service.telemetry[robot] = told | {"at_s": told["at_s"] + 0.1, "x_m": told["x_m"] + 0.1 * speed_m_s}


def test_telemetry_is_plotted_paused_and_read_off(page: Page, service: FakeService) -> None:
    bench = opened(page, "plots")
    bench.get_by_label("yard_2").check()
    for number in range(20):
        drives(service, "yard_1", 0.1 if number < 12 else 0.4)
        drives(service, "yard_2", 0.2)
        page.wait_for_timeout(120)
    speed = bench.locator("figure").first
    expect(speed).to_contain_text("yard_1 0.40")
    expect(speed).to_contain_text("yard_2 0.20")
    expect(speed.locator("polyline")).to_have_count(2)
    bench.get_by_label("pause").check()
    drives(service, "yard_1", 9.0)
    page.wait_for_timeout(300)
    expect(speed).to_contain_text("yard_1 0.40")
    bench.get_by_label("Time span").select_option("15 s")
    bench.get_by_role("group", name="Charts").focus()
    for _ in range(3):
        page.keyboard.press("ArrowLeft")
    expect(speed).to_contain_text("0.8 s ago")
    expect(speed).to_contain_text("yard_1 0.10")
    expect(bench.locator(".cursor").first).to_be_attached()
    bench.get_by_label("battery %").check()
    bench.get_by_label("table").check()
    expect(bench.get_by_role("row", name="battery % yard_1")).to_contain_text("97.0")
    expect(bench.get_by_role("row", name="speed m/s yard_1")).to_contain_text("0.40")


def test_the_behaviour_of_a_robot_is_laid_open(page: Page, service: FakeService) -> None:
    service.propose("move sample_1 to bay_1")
    service.approve("plan-1")
    service.navigate("yard_1", "mission-1")
    opened(page, "behaviour")
    expect(page.get_by_test_id("behaviour-script").locator("li").first).to_contain_text(
        "running yard_1 goes from"
    )
    conditions = page.get_by_test_id("behaviour-conditions")
    expect(conditions).to_contain_text("✓ before: the robot holds nothing, jaws open")
    expect(conditions).to_contain_text("✗ after: the robot is 1.70 m off the approach point of door_1")
    patterns = page.get_by_test_id("behaviour-patterns")
    expect(patterns).to_contain_text("translate/advance, task: response 0.95, utility 0.80")
    expect(patterns).to_contain_text("translate, resultant: response 0.95, utility 0.80")
    expect(patterns.locator("polyline")).to_have_count(4)
    data = {
        "robot": "yard_1",
        "packet": "a1",
        "at_s": 12.5,
        "events": ["toofast"],
        "detail": "drives at 0.6 m/s",
    }
    service.publish("packet.running", "mission-1", **data)
    expect(page.get_by_test_id("behaviour-events")).to_contain_text(
        "12.5 s packet.running: a1, toofast, drives at 0.6 m/s"
    )


def test_a_parameter_is_tuned_from_the_newest_version_or_not_at_all(page: Page, service: FakeService) -> None:
    opened(page, "behaviour")
    gain = page.get_by_test_id("tune-translate/advance-r.gain")
    gain.fill("0.5")
    gain.press("Enter")
    panel = page.get_by_test_id("behaviour-tuning")
    expect(panel).to_contain_text("version 1, pending")
    assert service.tuning["tuning"] == {"NAVIGATE": {"translate/advance": {"r.gain": 0.5}}}
    service.tune({})
    gain.fill("0.7")
    gain.press("Enter")
    expect(panel).to_contain_text("the tuning of yard_1 has changed")
    panel.get_by_role("button", name="Read again").click()
    expect(gain).to_have_value("1")
    expect(panel).to_contain_text("version 2")
    gain.fill("0.7")
    gain.press("Enter")
    panel.get_by_role("button", name="r.gain: original value").click()
    expect(panel).to_contain_text("version 4")
    assert service.tuning["tuning"] == {"NAVIGATE": {"translate/advance": {}}}


GUARD = "AGENT guard;\nBELIEF(startup) => COMMIT(adoptBelief(on_duty));\n"


def commitment(**fields: Any) -> dict[str, Any]:
    return {
        "rule": "guard:2",
        "name": "adoptBelief(on_duty)",
        "towards": "",
        "bindings": {},
        "made_s": 1.5,
        "state": "fulfilled",
        "reason": None,
        "words": "",
    } | fields


def belief(**fields: Any) -> dict[str, Any]:
    told = {"term": "on_duty", "value": True, "origin": "adopted", "source": "guard:2"}
    return told | {"words": "", "since_s": 2.0} | fields


def test_the_mind_of_a_robot_is_laid_open_and_followed(page: Page, service: FakeService) -> None:
    service.rule({"guard": GUARD})
    near = belief(term="close(ball)", value=False, origin="perceptor", words="is 1.7 m off ball")
    dropped = commitment(state="dropped", reason="condition", words="its condition no longer holds")
    agent = {
        "name": "guard",
        "roles": ["night_guard"],
        "beliefs": [belief(), near],
        "belief_count": 9,
        "commitments": [commitment(bindings={"?who": "store_1"}), dropped],
        "commitment_count": 2,
    }
    talk = {"protocol": "request", "partner": "store_1", "state": "agreed", "is_mine": False}
    service.mind |= {"agents": [agent], "conversations": [talk | {"reply_by_s": 34.0}]}
    opened(page, "mind")
    shown = page.get_by_test_id("agent-guard")
    expect(shown).to_contain_text("guard in the role night guard")
    expect(shown).to_contain_text("the newest 2 of 9")
    expect(shown.get_by_role("row", name="✓ on_duty")).to_contain_text("adopted, guard:2")
    expect(shown.get_by_role("row", name="✗ close(ball)")).to_contain_text("is 1.7 m off ball")
    expect(shown.get_by_role("row", name="fulfilled")).to_contain_text("?who = store_1")
    expect(shown.get_by_role("row", name="dropped")).to_contain_text("its condition no longer holds")
    expect(page.get_by_test_id("mind-conversations")).to_contain_text(
        "agreed request with store_1, opened by store_1, an answer is awaited until 34.0 s"
    )
    shown.get_by_role("button", name="guard:2").first.click()
    expect(page.get_by_test_id("rules-text")).to_be_focused()
    expect(page.get_by_test_id("rules-caret")).to_have_text("guard:2:1")
    service.mind = {"at_s": 13.0, "agents": [], "conversations": []}
    expect(page.get_by_test_id("mind-agents")).to_contain_text("The robot follows no rules.")


def test_a_breakpoint_is_set_at_a_rule_shows_where_the_world_stands_and_is_left(
    page: Page, service: FakeService
) -> None:
    service.rule({"guard": GUARD})
    opened(page, "mind")
    panel = page.get_by_test_id("mind-breakpoints")
    state = page.get_by_test_id("breakpoints-state")
    step = panel.get_by_role("button", name="Step")
    expect(state).to_contain_text("No breakpoints.")
    expect(step).to_be_disabled()
    text = page.get_by_test_id("rules-text")
    expect(text).to_have_value(GUARD)
    text.evaluate("area => { area.focus(); area.setSelectionRange(14, 14); }")
    panel.get_by_role("button", name="Break at the caret").click()
    expect(state).to_contain_text("The world runs until a rule with a breakpoint fires.")
    assert service.breakpoints["rules"] == ["guard:2"]
    firing = {"agent": "guard", "rule": "guard:2", "does": "DOCK", "bindings": {"what": "rock"}}
    agent = {"name": "guard", "roles": [], "beliefs": [belief(term="alarm")], "belief_count": 1}
    agent |= {"commitments": [], "commitment_count": 0}
    halt = {"robot": "yard_1", "at_s": 7.5, "firings": [firing], "agents": [agent]}
    service.breakpoints |= {"halts": [halt], "left_s": 590.0}
    expect(state).to_contain_text("yard_1 stands at 7.50 s; these rules have fired and take effect next:")
    expect(state).to_contain_text("guard: guard:2 DOCK, ?what = rock")
    expect(state).to_contain_text("If nobody goes on, it runs again in 10 min, without breakpoints.")
    expect(page.get_by_test_id("agent-guard")).to_contain_text("alarm")
    step.click()
    expect(state).to_contain_text("no breakpoint was met in this step")
    panel.get_by_role("button", name="Continue").click()
    until(lambda: [verb for verb, _, _ in service.decisions] == ["step", "continue"])
    expect(step).to_be_disabled()
    panel.get_by_role("button", name="Clear").click()
    expect(state).to_contain_text("No breakpoints.")
    service.breakpoints |= {"refusal": "a fleet drives sample_store"}
    expect(state).to_contain_text("a fleet drives sample_store")


def test_a_role_is_given_with_what_it_is_recruited_for_and_ended(page: Page, service: FakeService) -> None:
    opened(page, "mind")
    panel = page.get_by_test_id("mind-role")
    end = panel.get_by_role("button", name="End the role")
    expect(panel).to_contain_text("plays no role; version 0, rules untouched")
    expect(end).to_be_disabled()
    panel.get_by_label("Role", exact=True).fill("guard")
    panel.get_by_label("Home in this role").fill("door_1")
    boxes = panel.get_by_role("checkbox")
    expect(boxes.first).to_be_checked()
    boxes.first.uncheck()
    left_out = boxes.first.get_attribute("value")
    panel.get_by_role("button", name="Give the role").click()
    expect(panel).to_contain_text("plays guard; version 1, rules pending; by operator")
    assert (service.role["role"], service.role["home"], service.role["rules"]) == ("guard", "door_1", None)
    assert left_out not in service.role["tags"]
    service.play("porter")
    expect(panel).to_contain_text("plays porter; version 2")
    end.click()
    expect(panel).to_contain_text("plays no role; version 3")


def test_a_ring_is_replaced_by_its_virtual_counterpart_and_shown_as_virtual(
    page: Page, service: FakeService
) -> None:
    opened(page, "behaviour")
    shown = page.get_by_test_id("sensor-sources")
    source = shown.get_by_label("Source of ultrasonic")
    expect(source).to_have_value("real")
    source.select_option("virtual")
    expect(shown).to_contain_text("virtual: the echoes of the map's walls")
    assert service.sensor["source"] == "virtual"


def test_a_mind_is_moved_into_another_body_and_its_move_is_followed(page: Page, service: FakeService) -> None:
    opened(page, "behaviour")
    shown = page.get_by_test_id("embodiment")
    body = shown.get_by_label("Body")
    expect(body).to_have_value("velocity")
    expect(shown).to_contain_text("simulated")
    body.select_option("avatar")
    expect(shown).to_contain_text("a move to avatar is requested")
    expect(body).to_be_disabled()
    service.embody("yard_1", "avatar", state="embodied")
    expect(body).to_have_value("avatar")
    expect(shown).to_contain_text("virtual")
    expect(body).to_be_enabled()


def test_rules_are_sent_from_the_newest_version_and_without_faults_or_not_at_all(
    page: Page, service: FakeService
) -> None:
    opened(page, "mind")
    panel = page.get_by_test_id("mind-rules")
    send = panel.get_by_role("button", name="Send to the robot")
    expect(panel).to_contain_text("version 0, untouched")
    expect(send).to_be_disabled()
    panel.get_by_label("Name of a new file").fill("guard")
    panel.get_by_role("button", name="Add file").click()
    text = page.get_by_test_id("rules-text")
    expect(text).to_have_value("AGENT guard;\n")
    text.fill(GUARD.replace("COMMIT", "COMIT"))
    expect(panel).to_contain_text("changed here and not sent yet")
    send.click()
    expect(panel).to_contain_text("guard:2:21: expected COMMIT")
    assert service.rules["version"] == 0
    text.fill(GUARD)
    panel.get_by_label("Comment").fill("at night")
    send.click()
    expect(panel).to_contain_text("version 1, pending; sent by operator, “at night”")
    assert service.rules["files"] == {"guard": GUARD}
    expect(send).to_be_disabled()
    text.fill(f"{GUARD}// mine\n")
    service.rule({"guard": f"{GUARD}// of another\n"})
    expect(panel).to_contain_text("version 2")
    expect(text).to_have_value(f"{GUARD}// mine\n")
    send.click()
    expect(panel).to_contain_text("the rules of yard_1 have changed")
    panel.get_by_role("button", name="Read again").click()
    expect(text).to_have_value(f"{GUARD}// of another\n")
    panel.get_by_role("button", name="Remove file").click()
    send.click()
    expect(panel).to_contain_text("version 3, pending")
    assert service.rules["files"] == {}


def test_a_word_is_said_clarified_by_a_button_and_its_script_approved(
    page: Page, service: FakeService
) -> None:
    opened(page, "words")
    page.get_by_test_id("say-text").fill("fase the sample")
    page.get_by_test_id("say").click()
    expect(page.get_by_test_id("say-problem")).to_have_text("did you mean face?")
    page.get_by_test_id("say-text").fill("face the sample")
    page.get_by_test_id("say").click()
    dialogue = page.get_by_test_id("dialogue-dialogue-0")
    expect(dialogue).to_contain_text("asking face the sample")
    dialogue.get_by_role("button", name="sample_3").click()
    expect(dialogue).to_contain_text("FACE_OBJECT object sample_3, about 20 s")
    page.get_by_test_id("approve-words").click()
    expect(dialogue).to_contain_text("agreed face the sample")
    page.get_by_test_id("withdraw-words").click()
    expect(dialogue).to_contain_text("withdrawn face the sample")
    expect(page.get_by_test_id("withdraw-words")).to_have_count(0)


def test_any_performative_is_said_as_a_line_of_acl(page: Page, service: FakeService) -> None:
    opened(page, "words")
    page.get_by_test_id("say-act").select_option("subscribe")
    page.get_by_test_id("say-text").fill('weather("to day")')
    page.get_by_test_id("say").click()
    until(lambda: service.dialogues)
    assert service.dialogues[0]["text"] == 'SUBSCRIBE content:"weather(\\"to day\\")"'


def test_a_bid_is_accepted_in_its_own_dialogue(page: Page, service: FakeService) -> None:
    for number, last in enumerate(["propose", "agree"]):
        line = {"by": "yard_1", "performative": last, "content": "", "words": last}
        known = {"id": f"dialogue-{number}", "robot": "yard_1", "reason": "", "state": "said", "text": last}
        service.dialogues.insert(0, {**known, "script": [], "question": None, "lines": [line]})
    opened(page, "words")
    expect(page.get_by_test_id("dialogue-dialogue-0")).to_be_visible()
    page.get_by_test_id("say-act").select_option("accept-proposal")
    page.get_by_test_id("say-text").fill('award("a\\b")')
    page.get_by_test_id("say").click()
    until(lambda: len(service.dialogues[1]["lines"]) > 1)
    assert service.dialogues[1]["lines"][1]["words"] == 'ACCEPT-PROPOSAL content:"award(\\"a\\\\b\\")"'
