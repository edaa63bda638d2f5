"""Doors with software of their own are added, changed and removed, by operators and by what they announce."""

from typing import Any

import pytest

from app.domain.errors import Invalid, MactaError
from app.domain.world_model import initial_facts
from app.domain.world_model.edits import (
    AddPeripheral,
    ChangePeripheral,
    RemovePeripheral,
    WorldEdit,
    apply_edits,
)
from app.domain.world_model.factsheets import addition, difference, facts_said_by
from planner import Fact, load_knowledge_base
from robots.wire import Factsheet
from robots.world import Peripheral, WorldFile, load_world

BASE = load_knowledge_base()
STORE = load_world("guarded_store")
PANEL: dict[str, Any] = {"kind": "door", "start": (7.0, 4.0), "end": (7.0, 5.2)}


def door(name: str = "gate_9", **slots: object) -> Peripheral:
    return Peripheral.model_validate({**PANEL, "name": name, "external": True, **slots})


def sheet(
    peripheral: dict[str, Any] | None = PANEL, repertoire: tuple[str, ...] = ("OPEN", "CLOSE")
) -> Factsheet:
    return Factsheet(
        number=1, body="velocity", repertoire=repertoire, speed_m_s=0.5, turn_rad_s=1.0, peripheral=peripheral
    )


WITH_DOOR: WorldFile = AddPeripheral(peripheral=door()).apply(STORE, frozenset()).world


def test_a_door_that_is_added_is_closed_and_in_service_and_undoing_takes_both_back() -> None:
    before = initial_facts(STORE, BASE)
    added = apply_edits(STORE, [AddPeripheral(peripheral=door())], before, BASE)
    assert {Fact("closed", ("gate_9",)), Fact("operable", ("gate_9",))} <= added.facts - before
    undo = AddPeripheral(peripheral=door()).apply(STORE, before).undo
    back = apply_edits(added.world, [undo], added.facts, BASE)
    assert back.world.peripherals == STORE.peripherals
    assert not any("gate_9" in fact.args for fact in back.facts)


def test_a_door_that_changes_stays_as_it_stands() -> None:
    opened = Fact("opened", ("gate_9",))
    facts = initial_facts(WITH_DOOR, BASE) - {Fact("closed", ("gate_9",))} | {opened}
    edit = ChangePeripheral(peripheral=door(opening_s=9.0))
    after = apply_edits(WITH_DOOR, [edit], facts, BASE)
    assert after.world.agents_by_name["gate_9"] == door(opening_s=9.0)
    assert opened in after.facts
    assert Fact("closed", ("gate_9",)) not in after.facts
    assert edit.apply(WITH_DOOR, facts).undo == ChangePeripheral(peripheral=door())


@pytest.mark.parametrize(
    ("edit", "code"),
    [
        (AddPeripheral(peripheral=door("gate_8", external=False)), "peripheral-is-simulated"),
        (RemovePeripheral(name="gate_1"), "peripheral-is-simulated"),
        (ChangePeripheral(peripheral=door("gate_1")), "peripheral-is-simulated"),
        (ChangePeripheral(peripheral=door(external=False)), "peripheral-is-simulated"),
        (ChangePeripheral(peripheral=door(kind="hatch")), "peripheral-is-another"),
    ],
)
def test_simulated_doors_and_their_kind_are_changed_in_the_file_alone(edit: WorldEdit, code: str) -> None:
    with pytest.raises(MactaError) as refused:
        edit.apply(WITH_DOOR, frozenset())
    assert refused.value.code == code


@pytest.mark.parametrize("name", ["gate_1", "store_1", "sample_1", "bay_1"])
def test_a_door_takes_no_name_that_is_in_use(name: str) -> None:
    with pytest.raises(Invalid, match=f"the name {name} is in use"):
        AddPeripheral(peripheral=door(name)).apply(STORE, frozenset())


@pytest.mark.parametrize(
    "edit", [RemovePeripheral(name="gate_7"), ChangePeripheral(peripheral=door("gate_7"))]
)
def test_an_unknown_door_is_told_by_name(edit: WorldEdit) -> None:
    with pytest.raises(MactaError, match="gate_7"):
        edit.apply(WITH_DOOR, frozenset())


def test_a_door_that_announces_itself_is_added_as_it_says_and_external() -> None:
    assert addition("gate_9", sheet(), STORE) == AddPeripheral(peripheral=door())
    assert facts_said_by(door(), WITH_DOOR, BASE) == frozenset()


def test_a_factsheet_changes_its_door_only_if_it_says_something_else() -> None:
    assert difference(sheet(), door()) is None
    assert difference(sheet({**PANEL, "opening_s": 9.0}), door()) == ChangePeripheral(
        peripheral=door(opening_s=9.0)
    )


@pytest.mark.parametrize(
    ("said", "words"),
    [
        (sheet(repertoire=("OPEN",)), "the repertoire of a door is OPEN, CLOSE"),
        (sheet({**PANEL, "kind": "lift"}), "give start and end to each of its stops"),
        (sheet({**PANEL, "opening_s": 0}), "opening_s"),
    ],
)
def test_a_factsheet_of_no_door_is_refused_with_what_is_wrong(said: Factsheet, words: str) -> None:
    with pytest.raises(Invalid, match=words):
        addition("gate_9", said, STORE)


def test_a_door_does_not_become_a_robot_nor_a_robot_a_door() -> None:
    with pytest.raises(Invalid, match="gate_9 is a door of the world, and its factsheet describes none"):
        difference(sheet(None), door())
    with pytest.raises(Invalid, match="store_1 is a robot of the world, and its factsheet describes one"):
        difference(sheet(), STORE.robot("store_1"))
