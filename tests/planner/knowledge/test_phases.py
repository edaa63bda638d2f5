"""Times within actions: how they are written, what is refused, and the phases that they make."""

import textwrap
from collections.abc import Collection

import pytest

from benchmarks.planner.timed_store import timed_store
from planner import Fact, GroundAction, KnowledgeBase, KnowledgeBaseError
from planner.knowledge import read_knowledge_base

VOCABULARY = """
types: {robot: {}, place: {}, tag: {action_names: true}, time: {}}
functions: {drive_s: [place, place]}
predicates:
  stands: {arguments: {robot: robot, place: place}}
  clear: {arguments: {place: place}, make_way: true}
  seen: {arguments: {place: place}}
  can: {arguments: {robot: robot, tag: tag}}
  skilled: {arguments: {robot: robot}}
"""
OBJECTS = {"r": "robot", "a": "place", "b": "place"}


def base(
    *,
    needs: str = "clear(to) from end - 3",
    delete: str = "clear(to) at end - 3",
    intends: str = "stands(robot, to)",
    other: str = "clear(start) at start + 2",
    when: str = "can(robot, GO)",
    more: str = "",
) -> KnowledgeBase:
    """A knowledge base whose GO has these literals."""
    action = f"""
    actions:
      - identifier: 1
        name: GO
        parameters: [{{name: robot, type: robot}}, {{name: start, type: place}}, {{name: to, type: place}}]
        agents: [robot]
        preconditions: ["stands(robot, start)", "can(robot, GO)", "{needs}"]
        delete: ["stands(robot, start)", "{delete}"]
        intended_effects: ["{intends}"]
        other_effects: ["{other}"]
        phases_when: ["{when}"]
        duration: drive_s(start, to)
        distance: "8"
        energy: 2 * duration()
        description: "{{robot}} goes from {{start}} to {{to}}"
    """
    return read_knowledge_base(VOCABULARY + more + textwrap.dedent(action), "test")


def going(knowledge_base: KnowledgeBase, seconds: float = 20.0) -> GroundAction:
    arguments = {"robot": "r", "start": "a", "to": "b"}
    return knowledge_base.ground("GO", arguments, {("drive_s", ("a", "b")): seconds}, objects={**OBJECTS})


def go(
    knowledge_base: KnowledgeBase,
    seconds: float = 20.0,
    facts: Collection[Fact] = (Fact("can", ("r", "GO")),),
) -> tuple[GroundAction, ...]:
    """The phases of going from a to b."""
    whole = going(knowledge_base, seconds)
    return knowledge_base.phases_of(whole, facts)


def test_the_times_of_an_action_cut_it_into_phases() -> None:
    leave, drive, enter = go(base())
    assert [phase.duration_s for phase in (leave, drive, enter)] == [2.0, 15.0, 3.0]
    here, there = Fact("stands", ("r", "a")), Fact("stands", ("r", "b"))
    left, near = (Fact(f"under_way_go_{n}", ("r", "a", "b")) for n in (1, 2))
    can = Fact("can", ("r", "GO"))
    assert (leave.preconditions, leave.deletes) == ((here, can), (here,))
    assert leave.effects == (left, Fact("clear", ("a",)))
    assert (drive.preconditions, drive.deletes, drive.effects) == ((left, can), (left,), (near,))
    assert (enter.preconditions, enter.deletes) == (
        (near, can, Fact("clear", ("b",))),
        (near, Fact("clear", ("b",))),
    )
    assert (enter.intended_effects, enter.other_effects) == ((there,), ())
    assert sum(phase.distance_m for phase in (leave, drive, enter)) == pytest.approx(8.0)
    assert sum(phase.energy_j for phase in (leave, drive, enter)) == pytest.approx(40.0)


def test_an_action_too_short_for_its_times_stays_whole() -> None:
    assert [phase.duration_s for phase in go(base(), 6.0)] == [2.0, 1.0, 3.0]
    assert [phase.phase for phase in go(base(), 5.5)] == [0]


def test_an_action_that_has_become_too_short_has_its_times_shortened_in_proportion() -> None:
    knowledge_base = base()
    whole = going(knowledge_base, 4.0)
    phases = [knowledge_base.phase_of(whole, number) for number in range(1, 4)]
    assert [phase and phase.duration_s for phase in phases] == [1.44, 0.4, 2.16]
    assert knowledge_base.phase_of(whole, 0) is knowledge_base.phase_of(whole, 4) is None


def test_an_action_has_phases_only_where_the_facts_hold_that_it_names() -> None:
    knowledge_base = base(when="skilled(robot)")
    assert [phase.phase for phase in go(knowledge_base)] == [0]
    skilled = Fact("skilled", ("r",))
    phases = go(knowledge_base, facts=frozenset({skilled}))
    assert [phase.phase for phase in phases] == [1, 2, 3]
    assert all(skilled in phase.preconditions for phase in phases)
    assert [len(knowledge_base.steps_of(op)) for op in knowledge_base.operators] == [4]


def test_what_names_no_times_stays_one_action() -> None:
    plain = base(needs="clear(to)", delete="clear(to)", other="clear(start)")
    assert plain.phases == {}
    (whole,) = go(plain)
    assert (whole.phase, whole.phases) == (0, 0)


def test_an_effect_at_the_start_and_a_delete_at_the_end_take_no_time() -> None:
    phases = go(base(needs="clear(to) at end", delete="clear(to) at end", other="seen(start) at start"))
    assert [phase.duration_s for phase in phases] == [0.0, 20.0, 0.0]
    assert Fact("seen", ("a",)) in phases[0].effects
    assert [Fact("clear", ("b",)) in phase.preconditions for phase in phases] == [False, False, True]


def test_a_condition_until_a_time_lets_others_end_it_then() -> None:
    phases = go(base(needs="seen(start) until start + 5"))
    assert [phase.duration_s for phase in phases] == [2.0, 3.0, 12.0, 3.0]
    assert [Fact("seen", ("a",)) in phase.preconditions for phase in phases] == [True, True, False, False]


def test_phases_of_a_phase_are_itself() -> None:
    knowledge_base = base()
    for phase in go(knowledge_base):
        assert knowledge_base.phases_of(phase, frozenset()) == (phase,)


def test_an_action_of_several_robots_has_no_phases() -> None:
    divided = timed_store().phases
    assert "transport_near" in divided
    assert not any(len(phase.agents) > 1 for phases in divided.values() for phase in phases)


@pytest.mark.parametrize(
    ("slots", "said"),
    [
        ({"needs": "clear(to) at start + 3"}, "`at` start or end, or `from` and `until`"),
        ({"needs": "clear(to) from end - 3 until start + 1"}, "ends before it begins"),
        ({"needs": "clear(to) from soon"}, "'from soon' is no time"),
        ({"needs": "clear(to) from end - x"}, "'x' is no number of seconds"),
        ({"needs": "clear(to) from start from end"}, "says 'from' twice"),
        ({"delete": "clear(to) from end - 3"}, "`at` a time"),
        ({"delete": "clear(to) at end - 9"}, "deleted at end - 9, but needed from end - 3"),
        ({"delete": "seen(to) at end", "other": "seen(to) at start"}, "would hold only from start to end"),
        ({"when": "clear(to)"}, "GO changes clear; only what no action changes decides it"),
        ({"other": "stands(robot, to) at start + 2", "intends": "nothing(to)"}, "unknown predicate"),
    ],
)
def test_what_cannot_be_is_refused_with_its_place(slots: dict[str, str], said: str) -> None:
    with pytest.raises(KnowledgeBaseError, match="GO") as error:
        base(**slots)
    assert said in str(error.value)


def test_a_predicate_that_chains_phases_cannot_be_defined() -> None:
    with pytest.raises(KnowledgeBaseError, match="under_way_go_ are kept for it"):
        base(more="  under_way_go_x: {arguments: {place: place}}\n")
