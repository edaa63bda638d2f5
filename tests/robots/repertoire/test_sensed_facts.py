"""Facts that a pack's robots perceive: the condition for each is data."""

from dataclasses import replace
from pathlib import Path

import pytest

from robots.conditions.own_state import Measured
from robots.conditions.sight import InView
from robots.errors import RepertoireError
from robots.repertoire import load_repertoire, read_repertoire
from tests.robots.sensed import PROFILE
from tests.robots.stories import packet

FACTS = """\
sensed_facts:
  - fact: lit($me, $place)
    by: {sense: measured, quantity: light_lx, least: 100}
  - fact: seen($robot, $place)
    by: {sense: in_view, target: $place, for_s: 2}
"""
WAIT = """\
tag: WAIT
about: Waits.
patterns:
  - name: rest
    dof: translate
    level: self
    stimulus: {sense: always}
    r: {form: constant, value: 0}
    u: {form: constant, value: 1}
after: [{sense: empty}]
"""
READY = replace(PROFILE, repertoire=(*PROFILE.repertoire, "WAIT"))


def test_a_packet_that_awaits_such_a_fact_has_its_condition() -> None:
    repertoire = load_repertoire([("facts", FACTS), ("wait", WAIT)])
    bound = repertoire.bind(packet("WAIT", awaits=["lit(me, bay)", "seen(other, door)"]), READY)
    assert bound.before == (
        Measured(quantity="light_lx", least=100.0),
        InView(target="door", for_s=2.0),
    )


def test_another_robots_fact_is_not_this_ones() -> None:
    repertoire = load_repertoire([("facts", FACTS), ("wait", WAIT)])
    with pytest.raises(RepertoireError, match=r"has no sensor for lit\(other, bay\)"):
        repertoire.bind(packet("WAIT", awaits=["lit(other, bay)"]), READY)


def test_what_every_robot_perceives_needs_no_such_file() -> None:
    repertoire = load_repertoire([("facts", FACTS), ("wait", WAIT)])
    assert repertoire.bind(packet("WAIT", awaits=["vacant(bay)"]), READY).before


def test_they_stay_when_packets_are_tuned() -> None:
    tuned = load_repertoire([("facts", FACTS), ("wait", WAIT)]).tuned({})
    assert [one.fact for one in tuned.sensed] == ["lit($me, $place)", "seen($robot, $place)"]


def test_a_file_of_a_folder_may_hold_them(tmp_path: Path) -> None:
    (tmp_path / "facts.yaml").write_text(FACTS)
    assert len(read_repertoire([tmp_path / "facts.yaml"]).sensed) == 2


@pytest.mark.parametrize(
    ("right", "wrong", "words"),
    [
        ("lit($me, $place)", "lit $me", ["line 2, sensed_facts.0.fact", "not of the form"]),
        ("lit($me, $place)", "lit($me, ?place)", ["line 2, sensed_facts.0.fact", "not of the form"]),
        ("target: $place", "target: $spot", ["line 5, sensed_facts.1.by", "$spot is not in seen", "place"]),
        ("sense: in_view", "sense: inn_view", ["line 5, sensed_facts.1.by", "inn_view", "in_view"]),
        ("least: 100", "least: bright", ["line 3, sensed_facts.0.by", "least"]),
        ("  - fact: lit", "  - fakt: lit", ["line 2, sensed_facts.0.fakt"]),
    ],
)
def test_what_is_wrong_is_named_with_line_slot_and_choices(right: str, wrong: str, words: list[str]) -> None:
    with pytest.raises(RepertoireError) as refused:
        load_repertoire([("facts.yaml", FACTS.replace(right, wrong))])
    assert [word for word in (*words, "facts.yaml") if word not in str(refused.value)] == [], str(
        refused.value
    )


def test_a_fact_is_perceived_by_all_that_its_condition_reads_and_whatever_else_there_is() -> None:
    repertoire = load_repertoire([("facts", FACTS), ("wait", WAIT)])
    assert {"lit", "seen"} <= repertoire.senses(quantities={"light_lx", "dose_msv"})
    assert repertoire.senses(quantities={"dose_msv"}) & {"lit", "seen"} == {"seen"}
