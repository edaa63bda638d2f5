from importlib import resources

import pytest

from planner import Fact, KnowledgeBase, KnowledgeBaseError, read_knowledge_base

OBJECTS = {"yard_1": "robot", "sample_1": "object", "bay_7": "location", "door_1": "location", "yard": "area"}
FUNCTIONS = {("distance_m", ("door_1", "bay_7")): 3.0, ("speed_m_s", ("yard_1",)): 0.5}


def shipped() -> str:
    return (resources.files("planner.knowledge") / "files" / "rovers.yaml").read_text()


def test_the_six_actions_of_the_paper_are_data(knowledge_base: KnowledgeBase) -> None:
    assert set(knowledge_base.actions) == {"NAVIGATE", "DOCK", "TRANSPORT", "RELEASE1", "RELEASE2", "TRACK"}


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
        ("in", ("sample_1", "bay_99"), ["bay_99", "in(object, reference)", "bay_7"]),
        ("in", ("yard_1", "bay_7"), ["in(object, reference)"]),
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
        ("robot_position(robots, rel1, ref1)", "robot_position(robots, rel1, ref9)", "line 52, TRANSPORT"),
        (
            "reaches(robots, ref2)",
            "reached(robots, ref2)",
            "unknown predicate 'reached'; choices: can, clear",
        ),
        ("reaches(robots, ref2)", "reaches(robots)", "reaches takes (robot, location)"),
        ("gripper, full", "gripper, fool", "unknown condition 'fool'; choices: empty, full"),
        ("speed_m_s(robots) + 0.5", "speed_m_s(robots) ** 5", "TRANSPORT, duration"),
        (
            "speed_m_s(robots) + 0.5",
            "sped(robots) + 5",
            "unknown function 'sped'; choices: distance_m, speed_m_s",
        ),
        ("agents: [robots]", "agents: [robbers]", "TRANSPORT, agents: unknown parameter 'robbers'"),
        ('"{robots} transport', '"{rovers} transport', "TRANSPORT, description"),
        ("identifier: 2", "identifier: 1", "identifier: must be unique"),
        ("name: DOCK", "nom: DOCK", "name: Field required"),
        ("values: [at, near]", "values: [under]", "unknown relation 'under'; choices: at, in, near"),
    ],
)
def test_an_error_in_the_file_names_the_slot_and_the_choices(old: str, new: str, message: str) -> None:
    text = shipped()
    assert old in text
    with pytest.raises(KnowledgeBaseError) as error:
        read_knowledge_base(text.replace(old, new, 1), "kb.yaml")
    assert message in str(error.value)


def test_a_list_of_two_robots_holds_for_each_of_them() -> None:
    text = shipped().replace(
        "{name: robots, type: robot, teams: [1]}", "{name: robots, type: robot, teams: [1, 2]}", 1
    )
    base = read_knowledge_base(text, "kb.yaml")
    objects = {**OBJECTS, "yard_2": "robot"}
    functions = {**FUNCTIONS, ("speed_m_s", ("yard_2",)): 0.25}
    places = {"rel1": "near", "ref1": "door_1", "rel2": "near", "ref2": "bay_7", "area": "yard"}
    arguments = {"object": "sample_1", "robots": "yard_1+yard_2", **places}
    action = base.ground("TRANSPORT", arguments, functions, objects=objects)
    assert action.agents == ("yard_1", "yard_2")
    assert action.duration_s == pytest.approx(2 * 3.0 / 0.25 + 0.5)  # the slower one's
    for robot in action.agents:
        assert Fact("object_position", ("sample_1", "in", robot)) in action.preconditions
        assert Fact("robot_position", (robot, "near", "bay_7")) in action.other_effects
