"""The radio in a world file: what it may say, what a robot's own overrides, and how long an answer may then take."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from robots.world import Contact, LinkSpec, Outage, WorldFile, load_world
from tests.robots.world.test_file import refusal, small

WINDOWS = (Contact(start_s=5, for_s=10, every_s=120),)


def world(link: dict[str, Any], own: dict[str, Any] | None = None) -> WorldFile:
    robots = small()["robots"]
    if own is not None:
        robots[0]["link"] = own
    return WorldFile.model_validate(small(link=link, robots=robots))


def test_without_a_link_in_the_file_the_radio_is_perfect() -> None:
    quiet = WorldFile.model_validate(small())
    link = quiet.link_of(quiet.robot("left"))
    assert (link.loss, link.round_trip_s, link.silence_s, link.answer_s) == (0.0, 0.0, 0.0, 0.0)
    assert link.in_contact(0.0)


def test_a_robots_own_radio_overrides_only_what_it_says() -> None:
    here = world({"loss": 0.5, "delay_s": 2.0}, {"loss": 0.0})
    assert (here.link_of(here.robot("left")).loss, here.link_of(here.robot("left")).delay_s) == (0.0, 2.0)
    assert here.link_of(here.robot("right")).loss == 0.5


def test_what_a_robot_leaves_to_the_world_is_still_left_to_it_after_being_written_and_read() -> None:
    here = world({"delay_s": 2.0}, {"loss": 0.25})
    again = WorldFile.model_validate_json(here.model_dump_json())
    assert again == here
    assert again.link_of(again.robot("left")).delay_s == 2.0


@pytest.mark.parametrize(
    ("link", "said"),
    [
        ({"loss": 1.0}, "link.loss: Input should be less than or equal to 0.95"),
        ({"delay_s": -1.0}, "link.delay_s: Input should be greater than or equal to 0"),
        ({"losses": 0.1}, "link.losses: Extra inputs are not permitted"),
        ({"outages": [{"start_s": 5, "end_s": 5}]}, "an outage ends after it starts: end_s 5, start_s 5"),
        ({"outages": [{"start_s": 0, "end_s": 9, "every_s": 9}]}, "an outage of 9 s every 9 s never ends"),
        (
            {"contacts": [{"for_s": 20, "every_s": 20}]},
            "a contact of 20 s every 20 s has no end: leave it out",
        ),
        (
            {"light_time_s": 12, "contacts": [{"for_s": 10, "every_s": 60}]},
            "a contact of 10 s is shorter than the delivery of a message, which takes up to 12 s",
        ),
    ],
)
def test_an_impossible_radio_is_refused_by_slot(tmp_path: Path, link: dict[str, Any], said: str) -> None:
    assert said in refusal(tmp_path, link=link)


def test_a_robots_radio_that_does_not_go_with_the_worlds_is_refused(tmp_path: Path) -> None:
    robots = small()["robots"]
    robots[0]["link"] = {"light_time_s": 12}
    said = refusal(tmp_path, link={"contacts": [{"for_s": 10, "every_s": 60}]}, robots=robots)
    assert "robots.left.link with the world's:" in said


@pytest.mark.parametrize(
    ("at_s", "contact"), [(4.9, False), (5, True), (14.9, True), (15, False), (124.9, False), (125, True)]
)
def test_there_is_contact_in_its_windows_alone(at_s: float, contact: bool) -> None:
    assert LinkSpec(contacts=WINDOWS).in_contact(at_s) is contact


@pytest.mark.parametrize(
    ("every_s", "at_s", "contact"),
    [
        (None, 9, True),
        (None, 10, False),
        (None, 30, True),
        (100, 30, True),
        (100, 115, False),
        (100, 9, True),
    ],
)
def test_there_is_no_contact_in_an_outage(every_s: float | None, at_s: float, contact: bool) -> None:
    assert LinkSpec(outages=(Outage(start_s=10, end_s=30, every_s=every_s),)).in_contact(at_s) is contact


def test_an_answer_may_take_longer_the_poorer_the_radio() -> None:
    far = LinkSpec(light_time_s=4.0)
    assert far.answer_s == far.round_trip_s == 8.0
    assert LinkSpec(loss=0.5).answer_s == 16.0  # 17 tries, one a second: (1 - 0.25)^17 < 0.01
    assert LinkSpec(contacts=WINDOWS).answer_s == 110.0
    poor = LinkSpec(loss=0.5, contacts=WINDOWS)
    assert poor.answer_s > LinkSpec(contacts=WINDOWS).answer_s + LinkSpec(loss=0.5).answer_s


def test_of_several_contacts_the_one_that_comes_oftenest_ends_the_silence() -> None:
    link = LinkSpec(contacts=(*WINDOWS, Contact(for_s=5, every_s=30)))
    assert link.silence_s == 25.0


def test_an_example_world_has_a_poor_radio() -> None:
    poor = load_world("sample_store_radio")
    assert poor.link.loss > 0
    assert any(robot.link is not None for robot in poor.robots)
    same = load_world("sample_store")
    assert (poor.walls, poor.locations, poor.samples) == (same.walls, same.locations, same.samples)


def test_a_radio_is_read_from_yaml(tmp_path: Path) -> None:
    file = tmp_path / "room.yaml"
    file.write_text(yaml.safe_dump(small(link={"contacts": [{"start_s": 5, "for_s": 10, "every_s": 120}]})))
    assert load_world(file).link.contacts == WINDOWS


def test_a_link_cannot_lose_everything() -> None:
    with pytest.raises(ValidationError):
        LinkSpec(loss=0.99)


@pytest.mark.parametrize(
    ("link", "quiet_s"),
    [
        (LinkSpec(), 20.0),
        (LinkSpec(loss=0.5), 20.0),  # 20 words, one in 0.2 s, would be enough: 0.5^20 < 1e-6
        (LinkSpec(loss=0.95), 54.0),  # 270 words: 0.95^270 < 1e-6
        (LinkSpec(contacts=WINDOWS), 10.0),
        (LinkSpec(contacts=WINDOWS, light_time_s=2.0), 8.0),
        (LinkSpec(contacts=WINDOWS, loss=0.95), 54.0),
        (LinkSpec(contacts=(Contact(for_s=100, every_s=500),)), 20.0),
    ],
)
def test_a_silence_is_explained_by_loss_or_for_a_whole_window(link: LinkSpec, quiet_s: float) -> None:
    assert link.quiet_s == pytest.approx(quiet_s)


@given(
    start_s=st.floats(0, 50),
    for_s=st.floats(2, 20),
    gap_s=st.floats(1, 50),
    light_s=st.floats(0, 1.5),
    since_s=st.floats(0, 300),
    span_s=st.floats(0, 300),
)
@example(start_s=0, for_s=2, gap_s=1, light_s=1.5, since_s=0, span_s=4)
@settings(deadline=None, max_examples=30)
def test_what_could_be_heard_is_the_time_in_which_a_word_that_left_in_a_window_arrives_in_it(
    start_s: float, for_s: float, gap_s: float, light_s: float, since_s: float, span_s: float
) -> None:
    link = LinkSpec(
        light_time_s=light_s, contacts=(Contact(start_s=start_s, for_s=for_s, every_s=for_s + gap_s),)
    )
    (contact,) = link.contacts
    step_s = 0.01
    instants = [since_s + (n + 0.5) * step_s for n in range(int(span_s / step_s))]
    windows_of = [((at_s - start_s) // contact.every_s, at_s) for at_s in instants if link.in_contact(at_s)]
    # A word that arrives in a later window than it left in, for it takes longer than the gap, is not counted on.
    counted_s = step_s * sum(
        at_s - light_s >= start_s + window * contact.every_s for window, at_s in windows_of
    )
    windows = span_s / (for_s + gap_s) + 2
    assert abs(link.hearing_s(since_s, since_s + span_s) - counted_s) < step_s * (2 * windows + 1)


@given(st.floats(0, 1000))
def test_the_next_contact_is_the_first_instant_from_now_on_with_contact(at_s: float) -> None:
    link = LinkSpec(contacts=(*WINDOWS, Contact(start_s=30, for_s=5, every_s=70)))
    next_s = link.next_contact_s(at_s)
    assert next_s >= at_s
    assert link.in_contact(next_s + 1e-6)
    assert not any(link.in_contact(at_s + (next_s - at_s) * part / 50) for part in range(50) if next_s > at_s)
