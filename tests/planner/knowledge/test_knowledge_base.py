import pickle
import re
from importlib import resources
from pathlib import Path

import pytest

from planner import Fact, KnowledgeBase, KnowledgeBaseError, load_knowledge_base, read_knowledge_base

OBJECTS = {"yard_1": "robot", "sample_1": "object", "bay_7": "location", "door_1": "location", "yard": "area"}
FUNCTIONS = {("distance_m", ("door_1", "bay_7")): 3.0, ("speed_m_s", ("yard_1",)): 0.5}


def shipped() -> str:
    return (resources.files("planner.knowledge") / "files" / "rovers.yaml").read_text()


def test_the_six_actions_of_the_paper_and_those_of_ours_are_data(knowledge_base: KnowledgeBase) -> None:
    paper = {"NAVIGATE", "DOCK", "TRANSPORT", "RELEASE1", "RELEASE2", "TRACK"}
    operations = {"OPEN", "CLOSE", "MOVE_TO_LEVEL"}
    assert set(knowledge_base.actions) == {*paper, "DOCK2", "CARRY", "CHARGE", *operations}
    assert knowledge_base.operations == operations


def test_transport_has_the_slots_of_table_3(knowledge_base: KnowledgeBase) -> None:
    transport = knowledge_base.actions["TRANSPORT"]
    assert [p.name for p in transport.parameters if p.name != "area"] == [
        *("object", "robots", "rel1", "ref1", "rel2", "ref2", "time1", "time2")
    ]
    assert transport.agents == ("robots",)
    assert "robot_position(robots, rel1, ref1)" in transport.delete
    assert transport.intended_effects == ("transported(object, robots, rel1, ref1, rel2, ref2)",)
    assert "robot_position(robots, rel2, ref2)" in transport.other_effects


@pytest.mark.parametrize(
    ("fact", "form"),
    [
        (Fact("object_position", ("sample_1", "in", "bay_7")), ("in", ("sample_1", "bay_7"))),
        (Fact("object_position", ("sample_1", "in", "yard_1")), ("in", ("sample_1", "yard_1"))),
        (Fact("robot_position", ("yard_1", "near", "door_1")), ("near", ("yard_1", "door_1"))),
        (Fact("robot_position", ("yard_1", "at", "door_1")), ("at", ("yard_1", "door_1"))),
        (Fact("vacant", ("bay_7",)), ("vacant", ("bay_7",))),
        (
            Fact("robot_attribute", ("yard_1", "gripper", "full")),
            ("robot_attribute", ("yard_1", "gripper", "full")),
        ),
    ],
)
def test_facts_go_to_relations_and_back(
    knowledge_base: KnowledgeBase, fact: Fact, form: tuple[str, tuple[str, ...]]
) -> None:
    assert knowledge_base.to_relation(fact) == form
    assert knowledge_base.from_relation(*form, OBJECTS) == fact


@pytest.mark.parametrize(
    ("predicate", "args", "names"),
    [
        ("under", ("sample_1", "bay_7"), ["under", "in", "near", "vacant"]),
        ("in", ("sample_1", "bay_99"), ["bay_99", "in(thing, reference)", "bay_7"]),
        ("in", ("yard_1", "bay_7"), ["in(thing, reference)"]),
        ("vacant", ("sample_1",), ["sample_1", "bay_7", "door_1"]),
        ("vacant", (), ["vacant", "location"]),
    ],
)
def test_a_relation_that_does_not_fit_is_refused_with_the_choices(
    knowledge_base: KnowledgeBase, predicate: str, args: tuple[str, ...], names: list[str]
) -> None:
    with pytest.raises(KnowledgeBaseError) as refusal:
        knowledge_base.from_relation(predicate, args, OBJECTS)
    assert all(name in str(refusal.value) for name in names)


def test_a_robot_senses_an_object_in_a_place_but_not_in_another_gripper(
    knowledge_base: KnowledgeBase,
) -> None:
    assert knowledge_base.is_sensed(Fact("object_position", ("sample_1", "in", "bay_7")), OBJECTS)
    assert not knowledge_base.is_sensed(Fact("object_position", ("sample_1", "in", "yard_1")), OBJECTS)
    assert not knowledge_base.is_sensed(Fact("robot_position", ("yard_1", "near", "bay_7")), OBJECTS)


def test_grounding_gives_facts_agents_and_duration(knowledge_base: KnowledgeBase) -> None:
    arguments = {
        "robots": "yard_1",
        "rel1": "near",
        "ref1": "door_1",
        "rel2": "near",
        "ref2": "bay_7",
        "area": "yard",
    }
    action = knowledge_base.ground("NAVIGATE", arguments, FUNCTIONS, objects=OBJECTS)
    assert action.agents == ("yard_1",)
    assert action.duration_s == pytest.approx(3.0 / 0.5 + 1)
    assert action.intended_effects == (Fact("robot_position", ("yard_1", "near", "bay_7")),)
    assert dict(action.arguments) == arguments


def test_grounding_gives_distance_and_energy(knowledge_base: KnowledgeBase) -> None:
    places = {"rel1": "near", "ref1": "door_1", "rel2": "near", "ref2": "bay_7", "area": "yard"}
    drive = knowledge_base.ground("NAVIGATE", {"robots": "yard_1", **places}, FUNCTIONS, objects=OBJECTS)
    assert drive.distance_m == 3.0
    assert drive.energy_j == pytest.approx(11 * drive.duration_s + 25 * 3.0)
    arguments = {"object": "sample_1", "robots": "yard_1", "rel1": "near", "ref1": "door_1"}
    dock = knowledge_base.ground("DOCK", arguments, FUNCTIONS, objects=OBJECTS)
    assert (dock.distance_m, dock.energy_j) == (0.0, 11 * 2.5 + 5)


def test_an_action_without_figures_drives_and_uses_nothing() -> None:
    text = re.sub(r"    (distance|energy): .*\n", "", shipped())
    arguments = {"object": "sample_1", "robots": "yard_1", "rel1": "near", "ref1": "door_1"}
    dock = read_knowledge_base(text, "kb.yaml").ground("DOCK", arguments, FUNCTIONS, objects=OBJECTS)
    assert (dock.distance_m, dock.energy_j) == (0.0, 0.0)


def test_parameters_of_one_type_are_bound_to_different_objects(knowledge_base: KnowledgeBase) -> None:
    places = {"rel1": "near", "ref1": "door_1", "rel2": "near", "ref2": "door_1", "area": "yard"}
    with pytest.raises(KnowledgeBaseError, match="ref1 and ref2 are both 'door_1'"):
        knowledge_base.ground("NAVIGATE", {"robots": "yard_1", **places}, FUNCTIONS, objects=OBJECTS)


def test_grounding_refuses_an_argument_of_the_wrong_type(knowledge_base: KnowledgeBase) -> None:
    arguments = {"object": "sample_1", "robots": "door_1", "rel1": "near", "ref1": "bay_7"}
    with pytest.raises(KnowledgeBaseError, match=r"door_1.*no robot; choices: yard_1"):
        knowledge_base.ground("DOCK", arguments, {}, objects=OBJECTS)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "robot_position(robots, rel1, ref1)",
            "robot_position(robots, rel1, ref9)",
            "TRANSPORT, preconditions.0",
        ),
        (
            "robot_position(robots, rel1, ref1)",
            "robot_position(robots, rel1, ref9)",
            "line {line}, TRANSPORT",
        ),
        (
            "reaches(robots, ref2)",
            "reached(robots, ref2)",
            "unknown predicate 'reached'; choices: brought, can, charged",
        ),
        ("reaches(robots, ref2)", "reaches(robots)", "reaches takes (robot, location)"),
        ("gripper, full", "gripper, fool", "unknown condition 'fool'; choices: empty, full"),
        ("speed_m_s(robots) + 0.5", "speed_m_s(robots) ** 5", "TRANSPORT, duration"),
        (
            "speed_m_s(robots) + 0.5",
            "sped(robots) + 5",
            "unknown function 'sped'; choices: capacity_j, charger_w, closing_s, distance_m, opening_s, speed_m_s",
        ),
        (
            "distance: distance_m(ref1, ref2)",
            "distance: distance_m(ref1)",
            "TRANSPORT, distance: distance_m takes (location, location), not (ref1)",
        ),
        ("distance: distance_m(ref1, ref2)", "distance: duration()", "TRANSPORT, distance: unknown function"),
        (
            "energy: 11 * duration()",
            "energy: 6 * time()",
            "unknown function 'time'; choices: capacity_j, charger_w, closing_s, distance(), distance_m, duration(), ",
        ),
        ("energy: 11 * duration()", "energy: 6 ** duration()", "TRANSPORT, energy"),
        ("energy: 11 * duration()", "energy: 6 * duration(ref1)", "unknown function 'duration'"),
        (
            "speed_m_s: [robot]",
            "speed_m_s: [robot]\n  duration: []",
            "functions.duration: every knowledge base has it",
        ),
        ("agents: [robots]", "agents: [robbers]", "TRANSPORT, agents: unknown parameter 'robbers'"),
        ('"{robots} transport', '"{rovers} transport', "TRANSPORT, description"),
        ("identifier: 2", "identifier: 1", "identifier: must be unique"),
        ("name: DOCK", "nom: DOCK", "name: Field required"),
        ("values: [at, near]", "values: [under]", "unknown relation 'under'; choices: at, in, near"),
        (
            "location: {parent: reference}",
            "location: {parent: place}",
            "types.location.parent: unknown type 'place'",
        ),
        ("reference: {}", "reference: {parent: robot}", "its own ancestor: reference < robot < reference"),
        ("values: [empty, full]", "values: [near, full]", "near is a constant of relation already"),
        ("action_names: true", "action_names: perhaps", "types.tag.action_names"),
        ("[location, location]", "[location, place]", "functions.distance_m: unknown type 'place'"),
        ("[location, location]", "location", "functions.distance_m: Input should be a list"),
        (
            "arguments: {location: location}",
            "arguments: {location: place}",
            "predicates.vacant.arguments.location",
        ),
        (
            "arguments: {location: location}",
            "argument: {location: location}",
            "argument: there is no such slot",
        ),
        (
            "sensed_when: {ref: location,",
            "sensed_when: {reff: location,",
            "unknown argument 'reff'; choices: object, ",
        ),
        ("make_way: true", "make_way: 7", "predicates.clear.make_way"),
        (
            "held_by: robot_position",
            "held_by: robot_place",
            "predicates.zone_clear.held_by: unknown predicate 'robot_place'",
        ),
        (
            "arguments: {zone: zone}",
            "arguments: {zone: zone, area: area}",
            "predicates.zone_clear.held_by: zone_clear takes one argument, the zone",
        ),
        (
            'phrase: "{robot} reaches',
            'phrase: "{rover} reaches',
            "predicates.reaches.phrase: unknown argument 'rover'",
        ),
        ('denial: "{robot} cannot', 'denial: "{robot cannot', "predicates.can.denial"),
        ("name: DOCK\n", "name: NAVIGATE\n", "NAVIGATE, name: must be unique; used twice: NAVIGATE"),
        ("identifier: 2", "identifier: two", "NAVIGATE, identifier"),
        (
            "{name: object, type: thing}",
            "{name: object, type: things}",
            "TRANSPORT, parameters.0.type: unknown type",
        ),
        ("{name: object, type: thing}", "{name: robots, type: thing}", "parameters.1.name: must be unique"),
        ("teams: [1, 2]", "teams: [1, 1]", "parameters.1.teams.1: must be unique"),
        ("teams: [1, 2]", "teams: [5]", "parameters.1.teams.0"),
        ("agents: [robots]", "agents: []", "TRANSPORT, agents"),
        (
            "agents: [robots]",
            "agents: [robots]\n    distinct: [[ref1, time1]]",
            "distinct.0: unknown parameter 'time1'",
        ),
        ("delete: []", "delete:", "TRACK, delete: Input should be a list"),
        ("other_effects: []", "other_effects: [held(robot1)]", "other_effects.0: "),
        ("- tracked(robot1, robot2)", "- tracked(robot1, area)", "TRACK, intended_effects.0: area is a area"),
        ('duration: "7"', 'duration: "7 / 0"', "TRACK, duration: '7 / 0' divides by 0"),
        (
            'duration: "7"',
            'duration: "speed_m_s(area)"',
            "TRACK, duration: speed_m_s takes (robot), not (area)",
        ),
        ('duration: "7"', "duration: [7]", "TRACK, duration: Input should be a valid string"),
        ("agents: [robots]", "agents: []", "TRANSPORT, agents: The list should have at least 1 item"),
        (
            "    delete: []",
            "    delete: []\n    delete: [can(robot1, TRACK)]",
            "line {next_line}, delete: stands here for the second time, first in line {line}",
        ),
    ],
)
def test_an_error_in_the_file_names_the_slot_and_the_choices(old: str, new: str, message: str) -> None:
    text = shipped()
    line = text[: text.index(old)].count("\n") + 1
    with pytest.raises(KnowledgeBaseError) as error:
        read_knowledge_base(text.replace(old, new, 1), "kb.yaml")
    assert message.format(line=line, next_line=line + 1) in str(error.value)
    assert "kb.yaml" in str(error.value)
    assert re.search(r"line \d+, ", str(error.value))


def test_a_duration_may_be_a_number() -> None:
    text = shipped().replace('duration: "7"', "duration: 7.5")
    assert read_knowledge_base(text, "kb.yaml").actions["TRACK"].duration == "7.5"


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "kb.yaml").write_bytes(b"\xff\xfe")
    with pytest.raises(KnowledgeBaseError, match=r"kb.yaml is no text: invalid start byte at byte 0"):
        load_knowledge_base(tmp_path / "kb.yaml")


def test_a_list_of_two_robots_holds_for_each_of_them(knowledge_base: KnowledgeBase) -> None:
    objects = {**OBJECTS, "yard_2": "robot", "girder": "long_object"}
    functions = {**FUNCTIONS, ("speed_m_s", ("yard_2",)): 0.25}
    places = {"rel1": "near", "ref1": "door_1", "rel2": "near", "ref2": "bay_7", "area": "yard"}
    arguments = {"object": "girder", "robots": "yard_1+yard_2", **places}
    action = knowledge_base.ground("TRANSPORT", arguments, functions, objects=objects)
    assert action.agents == ("yard_1", "yard_2")
    assert action.duration_s == pytest.approx(4 * 3.0 / 0.25 + 5)  # the slower one's
    assert action.distance_m == 2 * 3.0  # each drives
    assert action.energy_j == pytest.approx(2 * (11 * action.duration_s + 25 * 3.0))
    for robot in action.agents:
        assert Fact("object_position", ("girder", "in", robot)) in action.preconditions
        assert Fact("robot_position", (robot, "near", "bay_7")) in action.other_effects


def test_it_can_be_sent_to_another_process(knowledge_base: KnowledgeBase) -> None:
    sent = pickle.loads(pickle.dumps(knowledge_base))
    arguments = {"robots": "yard_1", "rel1": "near", "ref1": "door_1", "rel2": "near", "ref2": "bay_7"}
    arguments["area"] = "yard"
    there, here = (
        base.ground("NAVIGATE", arguments, FUNCTIONS, objects=OBJECTS) for base in (sent, knowledge_base)
    )
    assert there == here


BOMB = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 12)
)
"""Three hundred thousand million values in twelve lines."""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BOMB, "line 6: more than 500000 values"),
        ("types: " + "[" * 5000 + "]" * 5000, "line 1: nested more than 50 deep"),
        ("types: &a [*a]", "line 1: the alias *a has no anchor before it"),
        ("types: " + "9" * 5000, "5000 digits"),
    ],
    ids=["bomb", "deep", "within itself", "digits"],
)
def test_a_file_that_would_take_for_ever_to_read_is_refused_in_one_line(text: str, words: str) -> None:
    with pytest.raises(KnowledgeBaseError) as refused:
        read_knowledge_base(text, "base.yaml")
    assert str(refused.value).startswith("base.yaml cannot be read: ")
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("formula", ["(" * 3000 + "1" + ")" * 3000, "-" * 9000 + "1", "1+" * 9000 + "1"])
def test_a_formula_that_is_nested_too_deeply_is_refused_by_name(formula: str) -> None:
    with pytest.raises(KnowledgeBaseError, match=r"duration: '.*longer than 300 characters"):
        read_knowledge_base(shipped().replace("duration: ", f"duration: {formula} + ", 1), "base.yaml")


def test_a_process_that_receives_a_knowledge_base_again_has_it_already() -> None:
    base = load_knowledge_base()
    received, again = (pickle.loads(pickle.dumps(base)) for _ in range(2))
    assert received is again
    assert received.file == base.file
