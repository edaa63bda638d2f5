"""Numbers that actions change: read, checked, and worked out for ground actions and their phases."""

from dataclasses import replace

import pytest

from planner import KnowledgeBaseError, load_knowledge_base, read_knowledge_base
from planner.knowledge.change import NumberChange
from tests.app.sample_store import Store
from tests.planner.knowledge.test_knowledge_base import shipped

BASE = load_knowledge_base()
FUNCTIONS = {
    ("distance_m", ("door_1", "bay_7")): 3.0,
    ("speed_m_s", ("yard_1",)): 0.5,
    ("capacity_j", ("yard_1",)): 1000.0,
    ("capacity_j", ("yard_2",)): 2000.0,
    ("charger_w", ("yard_1", "home_yard_1")): 58.0,
}
CHARGE = "until: battery(robot) <= 0.9"
RAISED = 'changes: ["battery(robot) += charger_w(robot, ref) * duration() / capacity_j(robot)"]'


@pytest.mark.parametrize(
    "text", ["battery(robot)", "battery += 1", "battery(robot) = 1", "battery(robot) += "]
)
def test_what_is_no_change_is_refused_with_its_form(text: str) -> None:
    with pytest.raises(KnowledgeBaseError, match="quantity\\(term, …\\) \\+= expression"):
        NumberChange.parse(text)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (RAISED, RAISED.replace("battery(robot)", "fuel(robot)"), "changes.0: unknown quantity 'fuel'"),
        (RAISED, RAISED.replace("battery(robot)", "load(robot)"), "changes.0: load is counted from facts"),
        (RAISED, RAISED.replace("battery(robot)", "battery(ref)"), "changes.0: ref is a location"),
        (RAISED, RAISED.replace("duration()", "time()"), "changes.0: unknown function 'time'"),
        (CHARGE, "until: battery(robot)", "until: 'battery(robot)' is not of the form"),
        (CHARGE, "until: load(robot) <= 1", "until: CHARGE does not change that number"),
        (CHARGE, "until: battery(robot) <= 2", "until: battery is 0 to 1, it cannot be 2"),
        ("kept: [0.2, null]", "kept: [-1, null]", "quantities.battery.kept: battery is 0 to 1, not -1"),
        (
            "used: energy()",
            "used: charger_w(robot)",
            "quantities.battery.used: charger_w takes (robot, location)",
        ),
        ("drain: (5 + waiting())", "drain: watts()", "quantities.battery.drain: unknown function 'watts'"),
        ("waiting: 4", "waiting: -4", "waiting: Input should be greater than or equal to 0"),
        ("used: energy()", "used: waiting()", "quantities.battery.used: unknown function 'waiting'"),
        (
            "counts: object_position(any, in, robot)",
            "counts: object_position(any, in, robot)\n    kept: [null, 1]",
            "quantities.load.counts: load is counted from facts, so that plans cannot keep it",
        ),
    ],
)
def test_a_fault_names_the_slot_and_the_choices(old: str, new: str, message: str) -> None:
    assert old in shipped()
    with pytest.raises(KnowledgeBaseError) as error:
        read_knowledge_base(shipped().replace(old, new, 1), "kb.yaml")
    assert message in str(error.value)


def test_driving_uses_the_battery_by_its_energy_and_charging_fills_it_by_its_time() -> None:
    store = Store()
    net = store.store_sample_1()
    drive = next(one for one in net.actions if one.agents == ("yard_1",))
    assert drive.energy_j > 0
    assert BASE.changed_numbers(drive, FUNCTIONS) == {("battery", ("yard_1",)): -drive.energy_j / 1000}
    charge = BASE.ground(
        "CHARGE",
        {"robot": "yard_1", "rel": "near", "ref": "home_yard_1"},
        FUNCTIONS,
        objects={"yard_1": "robot", "home_yard_1": "location"},
    )
    assert charge.duration_s == 10.0, "at least"
    shorter = replace(charge, duration_s=5.0)
    assert BASE.changed_numbers(shorter, FUNCTIONS) == {("battery", ("yard_1",)): 58 * 5 / 1000}


def test_phases_use_together_what_the_whole_action_does() -> None:
    store = Store()
    net = store.store_sample_1()
    drive = next(one for one in net.actions if one.tag == "TRANSPORT").unscheduled()
    (term,) = BASE.changed_numbers(drive, {**FUNCTIONS, ("capacity_j", drive.agents): 500.0})
    parts = [part for number in (1, 2, 3) if (part := BASE.phase_of(drive, number)) is not None]
    assert len(parts) > 1
    used = [BASE.changed_numbers(part, {("capacity_j", drive.agents): 500.0})[term] for part in parts]
    assert sum(used) == pytest.approx(-drive.energy_j / 500.0, rel=1e-3)


def test_the_functions_that_say_how_numbers_change_are_known() -> None:
    assert BASE.number_functions == {"capacity_j", "charger_w"}


def test_a_robot_with_no_known_capacity_uses_nothing() -> None:
    net = Store().store_sample_1()
    assert all(BASE.changed_numbers(action, {}) == {} for action in net.actions)
