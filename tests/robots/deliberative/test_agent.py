"""The interpreter: rules to commitments, commitments to actions."""

from dataclasses import replace
from pathlib import Path

import pytest

from robots.deliberative.actuators import DONE, Outcome
from robots.deliberative.agent import MAX_COMMITMENTS, Agent
from robots.deliberative.commitments import CommitmentState, DropReason, fulfil
from robots.deliberative.lint import check
from robots.deliberative.reader import read_rules, rules_of
from robots.deliberative.rehearsal import RecordedInstant, rehearse
from robots.deliberative.terms import Term, Value
from robots.errors import RuleError
from robots.perception.sensing import MutualDataStore
from robots.repertoire import load_repertoire
from tests.robots.deliberative.fake_actuators import FakeActuators
from tests.robots.sensed import percepts, sees

HEAD = "AGENT tester;\nACTUATOR activate, say, suspend, giveUp;\n"
DEFENDER = Path(__file__).with_name("defender.rules")


def agent(text: str, *others: str) -> tuple[Agent, FakeActuators]:
    files = [rules_of(HEAD + text, "tester.rules"), *(rules_of(one, "role.rules") for one in others)]
    check(files, load_repertoire())
    actuators = FakeActuators()
    return Agent("tester", files, actuators, known=[Term("me", ("fred",))]), actuators


def told(content: Value, sender: str = "anna", performative: str = "request") -> Term:
    return Term("message", (performative, sender, content))


def believed(one: Agent) -> set[str]:
    return {str(belief.term) for belief in one.beliefs}


def test_a_commitment_is_made_once_while_its_conditions_hold() -> None:
    one, actuators = agent(
        "BELIEF(startup) => COMMIT(adoptBelief(a));\nBELIEF(a) => COMMIT(activate(STOP()));"
    )
    for now_s in range(5):
        one.cycle(now_s)
    assert actuators.tags == ["STOP"]


def test_a_rehearsal_lists_each_firing_once_however_many_there_are_in_one_instant() -> None:
    text = HEAD + "".join(f"BELIEF(n({number}));" for number in range(100))
    text += "BELIEF(startup) & BELIEF(n(?x)) => COMMIT(adoptBelief(m(?x)));\n"
    instants = [RecordedInstant(percepts=replace(percepts(), time_s=float(at))) for at in range(4)]
    found = rehearse([rules_of(text, "tester.rules")], load_repertoire(), instants, robot="fred")
    assert [one.number for _, one in found.fired] == list(range(1, 101))


def test_an_event_lasts_one_cycle_and_one_that_comes_again_counts_again() -> None:
    one, actuators = agent("BELIEF(event(?tag, goal)) => COMMIT(say(inform, anna, at_goal(?tag)));")
    goal = Term("event", ("MOVE_TO", "goal"))
    one.cycle(0.0, [goal])
    assert "event(MOVE_TO, goal)" in believed(one)
    one.cycle(1.0, [goal])
    one.cycle(2.0)
    assert [str(one.content) for one in actuators.said] == ["at_goal(MOVE_TO)"] * 2
    assert "event(MOVE_TO, goal)" not in believed(one)


def test_a_rule_without_the_belief_it_refuses_holds_when_that_is_retracted() -> None:
    one, actuators = agent(
        "BELIEF(busy);\nBELIEF(message(request, ?_, free)) => COMMIT(retractBelief(busy));\n"
        "!BELIEF(busy) => COMMIT(activate(WANDER()));"
    )
    one.cycle(0.0)
    assert actuators.tags == []
    one.cycle(1.0, [told("free")])
    one.cycle(2.0)
    assert actuators.tags == ["WANDER"]


def test_a_sequence_goes_on_when_its_packet_has_succeeded_and_fails_with_it() -> None:
    text = "BELIEF(message(?_, ?_, go)) => COMMIT(SEQ(activate(STOP()), say(inform, anna, done)));"
    one, actuators = agent(text + "\nBELIEF(failed(?what)) => COMMIT(say(failure, anna, ?what));")
    one.cycle(0.0, [told("go")])
    one.cycle(1.0)
    assert actuators.said == []
    actuators.begun[0].outcome = DONE
    one.cycle(2.0)
    assert [str(said.content) for said in actuators.said] == ["done"]
    assert one.ended[-1].state is CommitmentState.FULFILLED
    one.cycle(3.0, [told("go")])
    actuators.begun[1].outcome = Outcome(False, "no way")
    one.cycle(4.0)
    assert (one.ended[-1].state, one.ended[-1].words) == (CommitmentState.FAILED, "no way")
    one.cycle(5.0)
    assert [(said.performative, said.content) for said in actuators.said] == [
        ("inform", "done"),
        ("failure", "STOP"),
    ]


def test_or_tries_the_next_action_and_par_waits_for_all() -> None:
    one, actuators = agent(
        "PLAN get_away(?rad) { OR(activate(STEP()), activate(TURN_LEFT(angle_rad: ?rad))) }\n"
        "BELIEF(startup) => COMMIT(PAR(get_away(0.5), DELAY(3), AWAIT(BELIEF(message(?_, ?_, go)))));"
    )
    one.cycle(0.0)
    actuators.begun[0].outcome = Outcome(False, "blocked")
    one.cycle(1.0, [told("go")])
    assert actuators.tags == ["STEP", "TURN_LEFT"]
    assert actuators.begun[1].wanted.arguments == {"angle_rad": "0.5"}
    actuators.begun[1].outcome = DONE
    one.cycle(2.0)
    assert one.commitments
    one.cycle(3.0)
    assert [ended.state for ended in one.ended] == [CommitmentState.FULFILLED]


def test_a_commitment_has_a_time_and_a_condition_to_keep() -> None:
    one, actuators = agent(
        "BELIEF(allowed);\nBELIEF(message(?_, ?who, go(?s))) & BELIEF(allowed)\n"
        "    => COMMIT(?who, Now + ?s, BELIEF(allowed), activate(STOP()));\n"
        "BELIEF(message(?_, ?_, stop)) => COMMIT(retractBelief(allowed));"
    )
    one.cycle(0.0, [told(Term("go", (5.0,)))])
    assert [(made.towards, made.state) for made in one.commitments] == [("anna", CommitmentState.ADOPTED)]
    one.cycle(4.9)
    assert actuators.tags == []
    one.cycle(5.0)
    assert [made.state for made in one.commitments] == [CommitmentState.ACTIVE]
    one.cycle(6.0, [told("stop")])
    one.cycle(7.0)
    assert one.commitments == []
    assert one.ended[-1].reason is DropReason.CONDITION
    assert actuators.begun[0].outcome is not None


def test_a_packet_waits_while_another_agents_packet_has_precedence_and_fails_if_it_is_refused() -> None:
    one, actuators = agent("BELIEF(startup) => COMMIT(activate(STOP()));")
    actuators.is_busy = True
    one.cycle(0.0)
    one.cycle(1.0)
    assert [made.state for made in one.commitments] == [CommitmentState.ACTIVE]
    actuators.is_busy = False
    actuators.refusal = "the robot holds sample_1"
    one.cycle(2.0)
    assert [(ended.state, ended.words) for ended in one.ended] == [
        (CommitmentState.FAILED, "the robot holds sample_1")
    ]


def test_a_role_applies_while_it_is_believed_and_its_commitments_end_with_it() -> None:
    role = "ROLE guard;\nACTUATOR activate;\nBELIEF(me(?_)) => COMMIT(activate(STOP()));"
    one, actuators = agent(
        "BELIEF(message(request, ?_, cover_role(?r))) => COMMIT(adoptBelief(role(?r)));\n"
        "BELIEF(message(request, ?_, leave_role(?r))) => COMMIT(retractBelief(role(?r)));",
        role,
    )
    one.cycle(0.0)
    assert actuators.tags == []
    one.cycle(1.0, [told(Term("cover_role", ("guard",)))])
    one.cycle(2.0)
    assert actuators.tags == ["STOP"]
    one.cycle(3.0, [told(Term("leave_role", ("guard",)))])
    one.cycle(4.0)
    assert one.ended[-1].reason is DropReason.CONDITION


def test_only_the_sensors_of_rules_that_may_fire_are_needed() -> None:
    one, _ = agent(
        "PERCEPTOR close(ball) IS close(object: ball);\nPERCEPTOR full IS not(of: empty());\n"
        "BELIEF(startup) => COMMIT(adoptBelief(a));\nBELIEF(a) & BELIEF(full) => COMMIT(suspend());\n"
        "BELIEF(message(?_, ?_, look)) => COMMIT(adoptBelief(looking));\n"
        "BELIEF(looking) & BELIEF(not(close(ball))) => COMMIT(suspend());"
    )
    assert one.all_needs == {"bumper", "gripper", "infra_red", "ultrasonic"}
    assert one.needs == frozenset()
    one.cycle(0.0)
    one.cycle(1.0)
    assert one.needs == {"gripper"}
    one.cycle(2.0, [told("look")])
    one.cycle(3.0)
    assert one.needs == {"bumper", "gripper", "infra_red", "ultrasonic"}


def test_a_perceptor_brings_its_belief_or_the_opposite_and_nothing_while_its_sensors_are_off() -> None:
    one, actuators = agent(
        "PERCEPTOR close(?x) IS close(object: ?x, m: 1) FOR ?x IN tracked;\n"
        "BELIEF(close(?x)) => COMMIT(activate(FACE_OBJECT(object: ?x)));"
    )
    one.cycle(0.0, percepts=percepts(sees("ball", 0.8), sees("rock", 3.0)))
    assert {"close(ball)", "not(close(rock))"} <= believed(one)
    assert [begun.wanted.arguments for begun in actuators.begun] == [{"object": "ball"}]
    known = one.beliefs.get(Term("close", ("ball",)))
    assert known is not None
    assert "0.80 m from ball" in known.words
    one.cycle(1.0, percepts=None)
    assert not any("close" in term for term in believed(one))


def test_the_figure_5_defender_moves_to_the_home_of_its_role_when_reset() -> None:
    file = read_rules(DEFENDER)
    actuators = FakeActuators()
    one = Agent("defender", [file], actuators)
    one.cycle(0.0, [told("reset")])
    assert actuators.tags == []  # it has no role yet
    one.cycle(1.0, [told(Term("cover_role", ("left_defender",)))])
    one.cycle(2.0, [told("reset")])
    assert [(said.performative, said.other, said.content) for said in actuators.said] == [
        ("agree", "anna", "reset")
    ]
    assert actuators.begun[0].wanted.arguments == {"x": "-3", "y": "-1.5"}
    one.cycle(3.0, [told(Term("cover_role", ("attacker",)))])
    one.cycle(4.0)
    actuators.begun[0].outcome = DONE
    one.cycle(5.0)
    assert "role(left_defender)" not in believed(one)
    one.cycle(6.0, [told("reset")])
    assert actuators.begun[1].wanted.arguments == {"x": "2", "y": "0"}


def test_too_many_commitments_are_dropped_and_named() -> None:
    one, _ = agent("BELIEF(message(?_, ?who, go)) => COMMIT(?who, Now + 9, activate(STOP()));")
    one.cycle(0.0, [told("go", f"robot_{number}") for number in range(MAX_COMMITMENTS + 1)])
    assert len(one.commitments) == MAX_COMMITMENTS
    assert [ended.reason for ended in one.ended] == [DropReason.OVERFLOW]


def test_what_has_ended_stays_ended() -> None:
    one, _ = agent("BELIEF(startup) => COMMIT(say(inform, anna, awake));")
    one.cycle(0.0)
    with pytest.raises(RuleError, match="commitment 1 of tester:3 cannot become fulfilled: it is fulfilled"):
        fulfil(one.ended[0], 1.0)


def test_what_a_cycle_commits_to_at_a_breakpoint_is_held_back_until_the_next_one() -> None:
    one, actuators = agent(
        "BELIEF(message(request, ?who, greet)) => "
        "COMMIT(?who, Now, BELIEF(message(request, ?who, greet)), say(agree, ?who, hello));\n"
        "BELIEF(message(request, ?_, greet)) => COMMIT(activate(STOP()));"
    )
    one.breakpoints = frozenset({"tester:3"})
    one.cycle(0.0, [told("greet")])
    assert (actuators.said, actuators.tags, one.commitments) == ([], [], [])
    assert [(held.rule, held.does, held.bindings) for held in one.held] == [
        ("tester:3", "say", {"who": "anna"}),
        ("tester:4", "STOP", {}),
    ]
    one.cycle(0.1)
    assert one.held == []
    assert [said.other for said in actuators.said] == ["anna"]
    assert actuators.tags == ["STOP"]


def test_a_rule_whose_commitment_is_live_meets_no_breakpoint() -> None:
    one, _ = agent("BELIEF(message(request, ?_, stop)) => COMMIT(activate(STOP()));")
    one.cycle(0.0, [told("stop")])
    one.breakpoints = frozenset({"tester:3"})
    one.cycle(0.1, [told("stop")])
    assert one.held == []


@pytest.mark.parametrize(("reads_at_s", "begins"), [(0.5, True), (60.0, False)])
def test_a_commitment_begins_once_the_sensors_of_what_it_is_to_keep_have_read(
    reads_at_s: float, begins: bool
) -> None:
    one, actuators = agent(
        "PERCEPTOR near(?x) IS closer(target: ?x, m: 1.0) FOR ?x IN tracked;\n"
        "BELIEF(message(request, ?_, stop)) => COMMIT(Self, Now, BELIEF(near(ball)), activate(STOP()));"
    )
    near = percepts(sees("ball", 0.8))
    off = replace(near, data=MutualDataStore({}))
    one.cycle(0.0, [told("stop")], off)
    for tick in range(1, 70):
        one.cycle(tick / 10, percepts=near if tick / 10 >= reads_at_s else off)
    assert actuators.tags == (["STOP"] if begins else [])
    assert [made.reason for made in one.ended] == ([] if begins else [DropReason.CONDITION])
