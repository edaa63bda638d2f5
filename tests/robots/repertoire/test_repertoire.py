"""Packets' contents are checked data; a packet that does not fit is refused by what does not fit."""

from dataclasses import replace
from pathlib import Path

import pytest

from robots.conditions.long_objects import AtHandle, JointNear, LinedUp
from robots.conditions.own_state import Holding
from robots.conditions.sight import Clear, LiesAt
from robots.errors import RepertoireError
from robots.reactive.patterns import Level
from robots.reactive.synthesis import DegreeOfFreedom
from robots.repertoire import load_repertoire, read_repertoire, store_packets
from robots.wire import BehaviourPacket
from robots.world.parts import PHASE_TAGS, STORE_TAGS
from tests.robots.sensed import PROFILE
from tests.robots.stories import packet

REPERTOIRE = load_repertoire()
MINIMAL = """
tag: WAIT
about: Waits.
arguments: []
patterns:
  - name: rest
    dof: translate
    level: self
    stimulus: {sense: always}
    r: {form: constant, value: 0}
    u: {form: constant, value: 1}
after: [{sense: empty}]
"""


def test_the_papers_packets_and_the_behavioural_suite_are_there() -> None:
    mission = {"NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2", "TRACK"}
    turns = {"TURN_LEFT", "TURN_RIGHT", "TURN_TO", "TURN_TOWARD"}
    follows = {"FOLLOW_LEFT_OBSTACLE", "FOLLOW_RIGHT_OBSTACLE"}
    suite = {"STOP", "STEP", "MOVE_TO", "FACE_OBJECT", "KICK", "WANDER"} | turns | follows
    long = {f"{tag} (long)" for tag in ("DOCK", "DOCK2", "DOCK2_OFF", "TRANSPORT", "RELEASE1", "RELEASE2")}
    phases = {*PHASE_TAGS} - {"DOCK2_OFF"}
    upkeep = {"SEEK_CHARGER", "CHARGE", "RECHARGE", "TELEOPERATE"}
    assert set(REPERTOIRE.specs) == mission | phases | suite | long | upkeep
    assert {tag for tag, spec in REPERTOIRE.specs.items() if spec.basic} == suite | upkeep


def test_the_four_levels_are_in_use() -> None:
    specs = REPERTOIRE.specs.values()
    assert {pattern.level for spec in specs for pattern in spec.bind({}).patterns} == set(Level)


def test_every_packet_that_drives_spares_a_low_battery() -> None:
    for spec in REPERTOIRE.specs.values():
        patterns = spec.bind({}).patterns
        drives = any(one.dof is DegreeOfFreedom.TRANSLATE for one in patterns)
        assert drives is any(one.name == "spare_battery" for one in patterns), spec.tag


def test_no_packet_has_two_patterns_of_one_name_on_one_degree_of_freedom() -> None:
    for spec in REPERTOIRE.specs.values():
        bound = spec.bind({})
        names = [(pattern.dof, pattern.name) for pattern in (*bound.patterns, *bound.retry)]
        assert len(names) == len(set(names)), spec.tag


def test_arguments_take_the_place_of_their_names() -> None:
    bound = REPERTOIRE.bind(packet("DOCK", object="sample", ref1="bay"), PROFILE)
    assert LiesAt(object="sample", place="bay") in bound.before
    assert bound.after == (Holding(object="sample"),)


def test_a_long_object_is_handled_with_a_packets_content_for_long_ones() -> None:
    bound = REPERTOIRE.bind(packet("DOCK", object="beam", ref1="bay"), PROFILE)
    assert LinedUp(target="beam@free") in bound.patterns[3].when
    assert Holding(object="beam") in bound.after


def test_who_docks_second_needs_a_long_object() -> None:
    with pytest.raises(RepertoireError, match="DOCK2 needs a long object; sample is not one for me"):
        REPERTOIRE.bind(packet("DOCK2", object="sample", robot2="other", ref2="bay"), PROFILE)


def test_a_robot_that_stands_at_a_handle_counts_as_holding_the_long_object() -> None:
    wanted = packet("DOCK2", object="beam", robot2="other", ref2="bay", awaits=["in(beam, other)"])
    assert REPERTOIRE.bind(wanted, PROFILE).before.count(AtHandle(object="beam", robot="other")) == 1


def test_a_long_object_counts_as_brought_by_where_its_middle_is() -> None:
    wanted = packet("RELEASE1", object="beam", robot2="other", awaits=["brought(beam, bay)"])
    told = [one for one in REPERTOIRE.bind(wanted, PROFILE).before if isinstance(one, JointNear)]
    assert [(one.object, one.place) for one in told] == [("beam", "bay")]


def test_what_a_packet_awaits_becomes_a_pre_condition_once() -> None:
    wanted = packet("DOCK", object="sample", ref1="bay", awaits=["in(sample, bay)", "clear(bay, hall)"])
    bound = REPERTOIRE.bind(wanted, PROFILE)
    assert bound.before.count(LiesAt(object="sample", place="bay")) == 1
    assert Clear(place="bay") in bound.before


def test_a_robots_own_spot_is_a_place_it_knows() -> None:
    REPERTOIRE.bind(packet("NAVIGATE", ref2="me_spot"), PROFILE)


@pytest.mark.parametrize(
    ("unfit", "names"),
    [
        (packet("FLY", ref2="bay"), "FLY"),
        (packet("NAVIGATE", ref1="bay"), "ref2"),
        (packet("NAVIGATE", ref2="moon"), "moon"),
        (packet("DOCK", ref1="bay"), "object"),
        (packet("TRACK", robot1="me", robot2="nobody"), "nobody"),
        (packet("TURN_LEFT", angle="1"), "TURN_LEFT has no parameter angle; known: angle_rad, max"),
        (packet("MOVE_TO", x="1", y="2", z="3"), "MOVE_TO has no parameter z"),
        (packet("MOVE_TO", x="nan", y="2"), "is not a point"),
        (packet("NAVIGATE", ref2="bay", awaits=["tracked(other, me)"]), r"tracked\(other, me\)"),
    ],
)
def test_a_packet_that_does_not_fit_is_refused_by_name(unfit: BehaviourPacket, names: str) -> None:
    with pytest.raises(RepertoireError, match=names):
        REPERTOIRE.bind(unfit, PROFILE)


def test_a_packet_outside_the_robots_repertoire_is_refused() -> None:
    with pytest.raises(RepertoireError, match="not in the repertoire of me"):
        REPERTOIRE.bind(packet("DOCK", object="s", ref1="bay"), replace(PROFILE, repertoire=("NAVIGATE",)))


def test_own_texts_make_a_repertoire() -> None:
    assert set(load_repertoire([("wait", MINIMAL)]).specs) == {"WAIT"}


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("sense: always", "sense: smell"),
        ("form: constant", "form: cubic"),
        ("dof: translate", "dof: fly"),
        ("level: self", "level: galaxy"),
        ("value: 0", "value: zero"),
        ("about: Waits.", "about: Waits.\nextra: 1"),
        ("after: [{sense: empty}]", "after: []"),
        ("tag: WAIT", "tag: ["),
    ],
)
def test_malformed_contents_are_an_error_that_names_the_text(right: str, wrong: str) -> None:
    with pytest.raises(RepertoireError, match="wait is no packet"):
        load_repertoire([("wait", MINIMAL.replace(right, wrong))])


def with_verbs(count: int) -> str:
    """The packet, which a person asks for by this number of verbs."""
    verbs = ", ".join(f"rest {'e' * number}" for number in range(1, count + 1))
    return MINIMAL.replace("about: Waits.", f"about: Waits.\nwords: [{{verbs: [{verbs}]}}]")


def test_a_packet_has_one_to_sixteen_verbs() -> None:
    (spec,) = load_repertoire([("wait", with_verbs(16))]).specs.values()
    assert len(spec.words[0].verbs) == 16
    for count in (0, 17):
        with pytest.raises(RepertoireError, match=r"words\.0\.verbs"):
            load_repertoire([("wait", with_verbs(count))])


def test_a_reading_of_nothing_is_no_result_of_a_packet() -> None:
    named = MINIMAL.replace("about: Waits.", "about: Waits.\nresults: [{reading: '', of: me}]")
    with pytest.raises(RepertoireError, match=r"results\.0\.reading"):
        load_repertoire([("wait", named)])


def test_a_tag_defined_twice_is_an_error() -> None:
    with pytest.raises(RepertoireError, match="a second time"):
        load_repertoire([("one", MINIMAL), ("two", MINIMAL)])


def test_a_packet_can_have_its_patterns_in_common_with_another() -> None:
    rest = MINIMAL[MINIMAL.index("  - name: rest") : MINIMAL.index("after:")]
    borrowing = MINIMAL.replace("tag: WAIT", "tag: STAND").replace(rest, "  - patterns_of: WAIT\n")
    specs = load_repertoire([("stand", borrowing), ("wait", MINIMAL)]).specs
    assert specs["STAND"].patterns == specs["WAIT"].patterns


def test_patterns_of_a_packet_that_is_not_there_are_an_error_that_names_both() -> None:
    rest = MINIMAL[MINIMAL.index("  - name: rest") : MINIMAL.index("after:")]
    with pytest.raises(RepertoireError, match="wait is no packet: patterns of DANCE"):
        load_repertoire([("wait", MINIMAL.replace(rest, "  - patterns_of: DANCE\n"))])


@pytest.mark.parametrize(
    ("right", "wrong", "words"),
    [
        (
            "sense: always",
            "sense: smell",
            ["line 9, patterns.0.stimulus", "unknown sense 'smell'", "bearing"],
        ),
        ("value: 0", "value: $much", ["line 6, patterns.0", "$much", "max_velocity_m_s"]),
        ("about: Waits.", "about: Waits.\nplaces: [ref1]", ["places: ref1 is not one of the arguments"]),
        ("about: Waits.", "about: Waits.\navoid: luck", ["avoid", "vfh_plus"]),
        (
            "about: Waits.",
            "about: Waits.\nevents: {late: [{sense: dusk}]}",
            ["line 4, events.late.0", "dusk"],
        ),
    ],
)
def test_what_is_wrong_with_a_packet_is_named_with_line_slot_and_choices(
    right: str, wrong: str, words: list[str]
) -> None:
    with pytest.raises(RepertoireError) as refused:
        load_repertoire([("wait", MINIMAL.replace(right, wrong))])
    assert [word for word in words if word not in str(refused.value)] == [], str(refused.value)


def test_files_add_packets_to_those_that_every_robot_has(tmp_path: Path) -> None:
    (tmp_path / "wait.yaml").write_text(MINIMAL)
    repertoire = read_repertoire([tmp_path / "wait.yaml"])
    assert repertoire.tags == ("WAIT",)
    assert {spec.tag for spec in repertoire.specs.values() if spec.basic} >= {"STOP", "CHARGE", "TELEOPERATE"}


def test_the_sample_stores_packets_are_files_like_any_others() -> None:
    assert read_repertoire(store_packets()).specs == load_repertoire().specs
    assert set(load_repertoire().tags) == {*STORE_TAGS, *PHASE_TAGS}


def test_a_packet_of_two_files_is_refused_naming_both(tmp_path: Path) -> None:
    files = [tmp_path / "one.yaml", tmp_path / "two.yaml"]
    for file in files:
        file.write_text(MINIMAL)
    with pytest.raises(RepertoireError) as refused:
        read_repertoire(files)
    assert all(str(file) in str(refused.value) for file in files)


def test_a_missing_packet_file_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(RepertoireError, match=r"nowhere\.yaml cannot be read"):
        read_repertoire([tmp_path / "nowhere.yaml"])
