"""What a person may say to one robot, and what the robot asks when it is not clear."""

from dataclasses import replace

import pytest

from app.domain.goal_language.clarification import Clarification
from app.domain.robot_language.references import WHICH_ONE, chosen
from app.domain.robot_language.surroundings import Surroundings, surroundings_of
from app.domain.robot_language.understand import (
    Ordered,
    Spoken,
    Stopped,
    answered,
    completed,
    understand,
)
from robots.repertoire import load_repertoire
from robots.wire import Telemetry
from tests.app.sample_store import Store

STORE = Store()
TWO_SEEN = {"sample_2": (3.0, 5.0), "sample_3": (3.0, 1.0)}


def around(robot: str = "yard_2", **known: object) -> Surroundings:
    told = {"at_s": 0.0, "x_m": 1.0, "y_m": 3.0, "heading_rad": 0.0} | known
    return surroundings_of(
        STORE.world.robot(robot),
        STORE.world,
        STORE.facts,
        load_repertoire(),
        telemetry=Telemetry.model_validate(told),
        points={},
    )


def packets(text: str, here: Surroundings | None = None) -> list[str]:
    understood = understand(text, here or around())
    assert isinstance(understood, Ordered), understood
    return [one.description for one in understood.packets]


def asked(text: str, here: Surroundings | None = None) -> Clarification:
    understood = understand(text, here or around())
    assert isinstance(understood, Clarification), understood
    return understood


@pytest.mark.parametrize(
    ("text", "packet"),
    [
        ("yard_2, face sample_1", "FACE_OBJECT(object sample_1)"),
        ("Yard 2: please face the Sample 1!", "FACE_OBJECT(object sample_1)"),
        ("REQUEST target:yard_2 action:face object:sample_1", "FACE_OBJECT(object sample_1)"),
        ("request action:face_object object:sample_1", "FACE_OBJECT(object sample_1)"),
        ("follow sample_1 for 20 seconds", "FACE_OBJECT(keep_distance_m 0.8, for_s 20, object sample_1)"),
        ("turn left", "TURN_LEFT()"),
        ("turn left 90°", "TURN_LEFT(angle_rad 1.5708)"),
        ("turn around", "TURN_LEFT(angle_rad 3.1416)"),
        ("REQUEST action:turn_left angle_rad:0.5", "TURN_LEFT(angle_rad 0.5)"),
        ("turn to sample_1", "TURN_TOWARD(object sample_1)"),
        ("go to door_1", "NAVIGATE(ref2 door_1)"),
        ("go to sample_1", "MOVE_TO(object sample_1)"),
        ("REQUEST action:move_to x:1 y:2", "MOVE_TO(x 1, y 2)"),
        ("come back home", "SEEK_CHARGER(ref2 home_yard_2)"),
        ("go back 50 cm", "STEP(distance_m -0.5)"),
        ("go back to door_1", "NAVIGATE(ref2 door_1)"),
        ("step forward half metre", "STEP(distance_m 0.5)"),
        ("take the sample", "DOCK(object sample_1, ref1 door_1)"),
        ("face the sample at door_1", "FACE_OBJECT(object sample_1)"),
        ("track yard_1", "TRACK(robot2 yard_1)"),
    ],
)
def test_a_command_is_a_packet_of_the_robots_repertoire(text: str, packet: str) -> None:
    assert packets(text) == [packet]


def test_commands_follow_each_other_and_it_is_what_the_last_one_named() -> None:
    assert packets("take sample_1, then carry it to interchange_1 and put down it at interchange_1") == [
        "DOCK(object sample_1, ref1 door_1)",
        "TRANSPORT(object sample_1, ref2 interchange_1)",
        "RELEASE2(object sample_1, ref2 interchange_1)",
    ]


def test_a_robot_that_holds_something_goes_with_it() -> None:
    assert packets("go to door_2", around(holding="sample_1")) == ["TRANSPORT(ref2 door_2, object sample_1)"]
    refused = asked("take sample_2", around("store_1", holding="sample_1"))
    assert "holds sample_1" in refused.detail


def test_a_packet_that_the_robot_has_not_is_not_understood() -> None:
    here = around()
    without = replace(here, packets=tuple(one for one in here.packets if one.tag != "TURN_LEFT"))
    refused = asked("turn left", without)
    assert (refused.code, refused.thing) == ("unknown-thing", "left")


def test_which_one_is_asked_of_those_in_view_and_answered_by_a_name_or_a_direction() -> None:
    here = around("store_1", tags=TWO_SEEN)
    text = "face the sample"
    question = asked(text, here)
    assert (question.code, question.choices) == (WHICH_ONE, ("sample_2", "sample_3"))
    assert question.detail == "which one? sample_2 or sample_3"
    answers = {
        one: answered(text, one, question, here)
        for one in (
            "sample 3",
            "the left one",
            "right",
            "the second one",
            "inform object:sample_3",
            "go home",
        )
    }
    assert answers == {
        "sample 3": "face the sample_3",
        "the left one": "face the sample_2",
        "right": "face the sample_3",
        "the second one": "face the sample_3",
        "inform object:sample_3": "face the sample_3",
        "go home": None,
    }
    assert packets(str(answers["the left one"]), here) == ["FACE_OBJECT(object sample_2)"]
    assert packets("face the left sample", here) == ["FACE_OBJECT(object sample_2)"]


def test_what_is_missing_is_asked_for_and_put_in_its_place() -> None:
    for text, whole in (
        ("face", "face sample_1"),
        ("go", "go to sample_1"),
        ("REQUEST action:face", "REQUEST action:face object:sample_1"),
    ):
        question = asked(text, around(tags={"sample_1": (2.0, 3.0)}))
        assert question.code == WHICH_ONE
        assert completed(text, question, "sample_1") == whole


def test_a_misplaced_word_is_answered_with_one_like_it_or_else_with_those_that_may_stand_there() -> None:
    assert asked("fase sample_1").detail == "'fase' cannot stand here; did you mean face?"
    assert asked("zzzz sample_1").detail.startswith(
        "'zzzz' cannot stand here; it could be approach, back off, "
    )


def test_the_word_of_a_command_may_be_part_of_a_name() -> None:
    assert asked("where is stop and go").thing == "stop and go"


def test_a_line_of_acl_asks_which_one_too() -> None:
    here = around("store_1", tags=TWO_SEEN)
    text = "REQUEST target:store_1 action:face object:sample"
    question = asked(text, here)
    assert question.choices == ("sample_2", "sample_3")
    assert answered(text, "sample_3", question, here) == "REQUEST target:store_1 action:face object:sample_3"


@pytest.mark.parametrize(
    ("text", "thing", "choice"),
    [
        ("fly to door_1", "fly", "face"),
        ("fase sample_1", "fase", "face"),
        ("go to bay_3", "bay_3", "door_1"),
        ("face sampel_1", "sampel_1", "sample_1"),
        ("turn left by half m", "", ""),
        ("drive forward 99 m", "99", ""),
        ("put down sample_1", "sample_1", ""),
        ("take sample_1 at door_2", "sample_1", ""),
        ("yard_1, stop", "yard_1", "yard_2"),
        ("REQUEST action:turn_left foo:9", "foo", "angle_rad"),
        ("REQUEST yard_2", "yard_2", "target:"),
        ("INFORM content:a(", "a(", ""),
        ("PROPOSE", "", "content:"),
    ],
)
def test_an_error_names_the_word_and_what_would_be_understood(text: str, thing: str, choice: str) -> None:
    refused = asked(text)
    assert refused.thing == thing
    assert not choice or choice in refused.choices


@pytest.mark.parametrize(
    ("text", "performative", "content"),
    [
        ("what do you see?", "query-ref", "seen"),
        ("where are you?", "query-ref", "position"),
        ("how is your battery?", "query-ref", "battery"),
        ("what are you doing?", "query-ref", "activity"),
        ("where is sample_1?", "query-ref", "place(sample_1)"),
        ("do you see sample_1?", "query-if", "sees(sample_1)"),
        ("QUERY-REF property:[position]", "query-ref", "position"),
        ("QUERY-IF content:holds(sample_1)", "query-if", "holds(sample_1)"),
        ("REQUEST action:cover_role property:[attacker]", "request", "cover_role(attacker)"),
        ("PROPAGATE content:news", "propagate", "news"),
        (r'INFORM content:"news(\"a \\\\ b\")"', "inform", r'news("a \\ b")'),
    ],
)
def test_questions_and_other_acts_are_terms(text: str, performative: str, content: str) -> None:
    said = understand(text, around())
    assert isinstance(said, Spoken)
    assert (said.performative, str(said.content)) == (performative, content)


@pytest.mark.parametrize(
    "text",
    ["stop", "yard_2, halt!", "REQUEST action:stop", "REQUEST content:halt", "REQUEST content:halt(x)"],
)
def test_stop_is_no_packet(text: str) -> None:
    assert understand(text, around()) == Stopped()


@pytest.mark.parametrize(
    "text",
    [
        'REQUEST content:"perform(x, packet(NAVIGATE, 600, ref1(bay_1)))"',
        "REQUEST action:perform property:[x, y]",
        r'REQUEST content:"\"perform\"(x, packet(STOP, 600))"',
    ],
)
def test_packets_are_not_stated_as_content_past_their_approval(text: str) -> None:
    refused = asked(text)
    assert (refused.thing, refused.choices) == ("perform", ("action:",))


def test_a_place_that_no_robot_enters_is_refused() -> None:
    refused = asked("go to door_1", replace(around(), kept_out={"door_1": "spill"}))
    assert refused.detail == "door_1 lies in spill, which no robot enters"


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("the first one", "sample_1"),
        ("the second one", "sample_2"),
        ("the last one", "sample_3"),
        ("the fourth one", None),
    ],
)
def test_of_several_one_is_chosen_by_its_number(said: str, meant: str | None) -> None:
    assert chosen(said, ("sample_1", "sample_2", "sample_3"), around("store_1")) == meant
