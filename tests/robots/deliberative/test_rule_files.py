"""Reading rule files, and what the linter finds in them."""

from pathlib import Path

import pytest

from robots.deliberative.lint import check
from robots.deliberative.perceptors import Perceptor
from robots.deliberative.program import Activate, Group, Joint, RuleFile, Say
from robots.deliberative.reader import digest_of, read_rules, rules_of
from robots.errors import RuleError
from robots.repertoire import load_repertoire

DEFENDER = Path(__file__).with_name("defender.rules")
HEAD = "AGENT tester;\nACTUATOR activate, say, suspend, giveUp;\n"


def linted(text: str, *others: str) -> RuleFile:
    files = [rules_of(HEAD + text, "tester.rules"), *(rules_of(one, "other.rules") for one in others)]
    check(files, load_repertoire())
    return files[0]


def refusal(text: str, *others: str) -> str:
    with pytest.raises(RuleError) as raised:
        linted(text, *others)
    return str(raised.value)


def test_the_defender_of_sra_figure_5_is_read_and_passes_the_linter() -> None:
    file = read_rules(DEFENDER)
    check([file], load_repertoire())
    assert (file.name, file.is_role, len(file.rules)) == ("defender", False, 5)
    assert [str(one.term) for one in file.initial] == [
        "Home(left_defender, -3, -1.5)",
        "Home(attacker, 2, 0)",
    ]
    reset = file.rules[2].step
    assert isinstance(reset, Group)
    assert reset.joint is Joint.SEQ
    assert [type(one) for one in reset.steps] == [Say, Activate]
    assert Perceptor(file.perceptors[0]).needs == {"ultrasonic", "infra_red", "gripper", "bumper"}


def test_the_version_is_of_the_text_however_its_lines_end() -> None:
    text = DEFENDER.read_text()
    assert digest_of(text) == digest_of(text.replace("\n", "\r\n") + "\n")
    assert digest_of(text) != digest_of(text.replace("-1.5", "-1.6"))


def test_all_faults_of_a_file_are_named_with_line_and_column() -> None:
    words = refusal("BELIEF(a) & b => COMMIT(f);\nBELIEF(a) => COMMIT(say(inform));\nACTUATOR sya;")
    assert words.splitlines() == [
        "tester.rules:3:13: expected BELIEF(...), !BELIEF(...) or a comparison",
        "tester.rules:4:21: say takes a performative, a receiver and a content",
        "tester.rules:5:10: unknown actuator sya; did you mean say?",
    ]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("BELIEF(startup) =>", "3:19: the end of the file cannot stand here; expected !, +, -, ["),
        ("BELIEF(startup => COMMIT(f);", "3:16: '=>' cannot stand here; expected &, (, ), "),
        ("BELIEF(startup) => COMMIT(suspend()) $", "3:38: '$' cannot stand here; expected &, "),
        ("BELIEF(startup) => suspend();", "3:20: expected COMMIT(action)"),
        ("BELIEF(f(" + 25 * "g(" + "x" + 25 * ")" + "));", "nested more than 20 deep"),
        ("BELIEF(not(?x)) => COMMIT(suspend());", "3:8: not takes one belief"),
        ("BELIEF(startup) => COMMIT(Self, Later, suspend());", "3:33: a time is Now, or Now + seconds"),
        ("BELIEF(at(?x));", "3:1: an initial belief has no variables: at(?x)"),
        (
            "PERCEPTOR near(?x) IS close(object: ?x);\nBELIEF(startup) => COMMIT(suspend());",
            "3:1: ?x ranges over nothing: add FOR ?x IN one of me, places, robots, tracked",
        ),
        ("PERCEPTOR near IS clsoe(object: ball);", "3:1: unknown sense 'clsoe'; choices: abeam, "),
        (
            "PERCEPTOR near IS close(object: ball, m: 99);",
            "3:1: close.m: Input should be less than or equal to 10",
        ),
        (
            "PERCEPTOR still IS not(of: at_rest());",
            "at_rest is a condition on a packet; believe event(TAG, name)",
        ),
        ("PERCEPTOR near(?x) IS close(object: ?x) FOR ?x IN sky;", "3:1: unknown domain sky; choices: me, "),
        (
            "PERCEPTOR close(ball) IS close(object: ball);\nBELIEF(clsoe(ball)) => COMMIT(suspend());",
            "4:1: never holds: no perceptor, event, initial belief or adoptBelief brings clsoe(ball); "
            "did you mean close/1?",
        ),
        ("BELIEF(event(goal)) => COMMIT(suspend());", "brings event(goal); did you mean event/2?"),
        (
            "BELIEF(startup) & !BELIEF(startup) => COMMIT(suspend());",
            "3:19: never holds together with BELIEF(startup)",
        ),
        ("BELIEF(startup) & 3 < 2 => COMMIT(suspend());", "3:19: never holds: 3 < 2"),
        ("BELIEF(me(?a)) & ?a != ?a => COMMIT(suspend());", "3:18: never holds: ?a != ?a"),
        (
            "BELIEF(startup) & !BELIEF(role(?r)) => COMMIT(adoptBelief(lost(?r)));",
            "3:47: ?r is not bound: no positive BELIEF of the rule contains it",
        ),
        ("BELIEF(startup) & ?x < 3 => COMMIT(suspend());", "3:19: ?x is not bound: no positive BELIEF"),
        (
            "BELIEF(startup) => COMMIT(activate(MOV_TO(x: 1, y: 2)));",
            "3:27: unknown packet MOV_TO; did you mean",
        ),
        ("BELIEF(startup) => COMMIT(activate(MOVE_TO(x: 1)));", "MOVE_TO needs either object, or x and y"),
        (
            "BELIEF(startup) => COMMIT(activate(TURN_LEFT(angle: 1)));",
            "no parameter angle; did you mean angle_rad?",
        ),
        (
            "BELIEF(startup) => COMMIT(activate(TURN_LEFT(angle_rad: 99)));",
            "angle_rad = 99 is not within 0 to",
        ),
        (
            "BELIEF(startup) => COMMIT(activate(STOP(timeout_s: soon)));",
            "3:27: STOP: timeout_s = soon is no number of seconds",
        ),
        ("BELIEF(startup) => COMMIT(Self, Now + 1e999, suspend());", "3:39: 1e999 is too large for a number"),
        ("BELIEF(at(-1e999));", "3:11: 1e999 is too large for a number"),
        ("BELIEF(startup) => COMMIT(activate(SEEK_CHARGER()));", "SEEK_CHARGER lacks the argument ref2"),
        ("BELIEF(startup) => COMMIT(retry());", "3:27: retry is not declared; add ACTUATOR retry;"),
        (
            "BELIEF(startup) => COMMIT(say(infrom, a, b));",
            "unknown performative infrom; did you mean inform?",
        ),
        ("BELIEF(startup) => COMMIT(suspnd());", "unknown action or plan suspnd; plans: none"),
        (
            "PLAN p(?x) { DELAY(?x) }\nBELIEF(startup) => COMMIT(p());",
            "4:27: the plan p takes 1 values, not 0",
        ),
        ("PLAN p() { q() }\nPLAN q() { p() }\n", "the plan p runs itself"),
        ("PLAN p() { DELAY(?x) }\n", "3:12: ?x is not bound: no parameter of the plan contains it"),
        ("BELIEF(startup) => COMMIT(adoptBelief(startup));", "startup comes from the robot itself"),
        (
            "PERCEPTOR close(ball) IS close(object: ball);\nBELIEF(startup) => COMMIT(adoptBelief(close(?_)));",
            "close(?_) is sensed by a perceptor",
        ),
    ],
)
def test_a_fault_is_named_with_its_place_and_the_way_out(text: str, words: str) -> None:
    assert words in refusal(text)


def test_an_actuator_may_be_limited_to_some_packets_and_performatives() -> None:
    text = "AGENT a;\nACTUATOR activate(STOP), say(inform);\nBELIEF(startup) => COMMIT(activate(WANDER()));\n"
    with pytest.raises(
        RuleError, match=r"a.rules:3:27: WANDER is not among those of ACTUATOR activate\(STOP\)"
    ):
        check([rules_of(text, "a.rules")], load_repertoire())


def test_what_is_said_is_named_where_performatives_are_limited() -> None:
    text = "AGENT a;\nACTUATOR say(inform, agree);\nBELIEF(message(?p, ?who, ?what)) => COMMIT(say(?p, ?who, ?what));\n"
    words = r"a.rules:3:44: \?p may be any performative; write one of ACTUATOR say\(agree, inform\), or ACTUATOR say"
    with pytest.raises(RuleError, match=words):
        check([rules_of(text, "a.rules")], load_repertoire())
    check([rules_of(text.replace("say(inform, agree)", "say"), "a.rules")], load_repertoire())


def test_the_files_of_one_agent_are_checked_together() -> None:
    role = "ROLE guard;\nACTUATOR suspend;\nBELIEF(alarm) => COMMIT(suspend());\n"
    with pytest.raises(RuleError, match="brings alarm"):
        check([rules_of(role, "guard.rules")], load_repertoire())
    linted("BELIEF(startup) => COMMIT(adoptBelief(alarm));", role)
    assert "both define tester" in refusal("", "ROLE tester;")


def test_a_text_that_is_too_long_is_refused_unread() -> None:
    with pytest.raises(RuleError, match="a rule file has at most 65536"):
        rules_of("AGENT a;" + " " * 70_000, "long.rules")
