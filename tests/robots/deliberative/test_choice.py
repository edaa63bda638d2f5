"""Plans of one name compete: the cheapest whose context holds runs, and the next one if it fails (P-SMPA §4)."""

from dataclasses import replace

import pytest

from robots.deliberative.actuators import Outcome
from robots.deliberative.agent import Agent
from robots.deliberative.commitments import CommitmentState
from robots.deliberative.costs import cost_of
from robots.deliberative.lint import check
from robots.deliberative.reader import rules_of
from robots.deliberative.steps import FIRST_READING_S
from robots.deliberative.terms import Term
from robots.errors import RuleError
from robots.perception.sensing import MutualDataStore
from robots.repertoire import load_repertoire
from tests.robots.deliberative.fake_actuators import FakeActuators
from tests.robots.sensed import percepts, sees

HEAD = "AGENT tester;\nACTUATOR activate;\n"
CHARGE = (
    HEAD
    + """
BELIEF(charger(north)), BELIEF(charger(south));
BELIEF(message(request, ?_, charge)) => COMMIT(charge());
PLAN charge() WHEN BELIEF(charger(?place)) COST way(?place) { activate(SEEK_CHARGER(ref2: ?place)) }
PLAN charge() WHEN !BELIEF(message(inform, ?_, wait)) COST 10 * battery + 5 { activate(STOP) }
"""
)
ASKED = Term("message", ("request", "anna", "charge"))
WAIT = Term("message", ("inform", "anna", "wait"))


def choosing(text: str = CHARGE, **ways_s: float) -> tuple[Agent, FakeActuators]:
    file = rules_of(text, "tester.rules")
    check([file], load_repertoire())
    body = FakeActuators(
        measures={("way", name): each for name, each in ways_s.items()} | {("battery",): 0.5}
    )
    return Agent("tester", [file], body), body


def begun(body: FakeActuators) -> list[tuple[str, str]]:
    return [(one.wanted.tag, one.wanted.arguments.get("ref2", "")) for one in body.begun]


def test_the_cheapest_instance_runs_and_the_choice_is_told() -> None:
    agent, body = choosing(north=8.0, south=3.0)
    agent.cycle(0.0, [ASKED])
    assert begun(body) == [("SEEK_CHARGER", "south")]
    (made,) = agent.commitments
    assert made.words == "charge of line 6 costs 3; charge of line 6 costs 8; charge of line 7 costs 10"


def test_a_cost_is_an_expression_over_measures_of_the_robot() -> None:
    _, body = cheapest = choosing(north=18.0, south=13.0)
    cheapest[0].cycle(0.0, [ASKED])
    assert begun(body) == [("STOP", "")]


def test_the_next_plan_is_tried_when_one_fails_and_the_last_failure_says_all() -> None:
    agent, body = choosing(north=8.0, south=3.0)
    agent.cycle(0.0, [ASKED])
    for number in range(3):
        body.begun[-1].outcome = Outcome(False, f"reason {number}")
        agent.cycle(1.0 + number)
    assert begun(body) == [("SEEK_CHARGER", "south"), ("SEEK_CHARGER", "north"), ("STOP", "")]
    (made,) = [one for one in agent.ended if one.name == "charge"]
    assert made.state is CommitmentState.FAILED
    assert all(f"reason {number}" in made.words for number in range(3))


def test_a_plan_whose_context_does_not_hold_or_whose_cost_is_not_known_is_rejected() -> None:
    agent, body = choosing(south=3.0)
    agent.cycle(0.0, [ASKED, WAIT])
    assert begun(body) == [("SEEK_CHARGER", "south")]
    (made,) = agent.commitments
    assert made.words.endswith("charge of line 6 has no known cost; charge of line 7 does not apply")


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (
            "PLAN p() { activate(STOP) }\nPLAN p() { activate(STOP) }",
            "plans that compete have WHEN or COST each",
        ),
        (
            "PLAN p() COST 1 { activate(STOP) }\nPLAN p(?x) COST 2 { activate(STOP) }",
            "different numbers of parameters",
        ),
        ("PLAN p() COST ?x { activate(STOP) }", "?x is not bound: no parameter of the plan"),
        (
            "PLAN p() COST weather { activate(STOP) }",
            "a cost has no weather; it has numbers, ?variables and way/1, battery/0, lasts/1",
        ),
        ("PLAN p() COST 2 * lasts(DUCK) { activate(STOP) }", "unknown packet DUCK; did you mean DOCK?"),
        ("PLAN p() WHEN BELIEF(never_said) { activate(STOP) }", "never holds: no perceptor"),
    ],
)
def test_plans_that_cannot_compete_are_refused(text: str, fault: str) -> None:
    with pytest.raises(RuleError) as refused:
        choosing(HEAD + text)
    assert fault in str(refused.value)


def test_a_bid_of_others_may_still_name_its_cost() -> None:
    rule = "BELIEF(message(propose, ?who, bid(?leg, cost(?cost)))) => COMMIT(adoptBelief(when(?who, ?cost)));"
    agent, _ = choosing(HEAD + rule)
    agent.cycle(0.0, [Term("message", ("propose", "bob", Term("bid", ("leg", Term("cost", (9.0,))))))])
    agent.cycle(0.1)
    assert Term("when", ("bob", 9.0)) in agent.beliefs


@pytest.mark.parametrize("bound", ["north", "foo(bar)", "way", "battery", "way(south)"])
def test_a_variable_that_is_bound_to_no_number_costs_nothing_known(bound: str) -> None:
    agent, body = choosing(
        south=3.0,
        text=HEAD
        + f"BELIEF(prefers({bound}));\nBELIEF(message(request, ?_, charge)) => COMMIT(charge());\n"
        + "PLAN charge() WHEN BELIEF(prefers(?x)) COST ?x { activate(STOP) }\n"
        + "PLAN charge() COST 5 { activate(SEEK_CHARGER(ref2: south)) }",
    )
    agent.cycle(0.0, [ASKED])
    assert begun(body) == [("SEEK_CHARGER", "south")]


@pytest.mark.parametrize(
    ("cost", "value"),
    [
        ("10 * battery + way(south)", 8.0),
        ("2 + 3 * 4", 14.0),
        ("way(south) * way(south)", 9.0),
        ("1 + way(nowhere)", None),
        ("0 * way(nowhere)", None),
    ],
)
def test_a_cost_is_known_if_all_its_parts_are(cost: str, value: float | None) -> None:
    (plan,) = rules_of(f"{HEAD}PLAN p() COST {cost} {{ activate(STOP) }}", "tester.rules").plans["p"]
    _, body = choosing(south=3.0)
    assert cost_of(plan.cost, {}, body.measure) == value


BLIND = (
    HEAD
    + """
PERCEPTOR near(?x) IS closer(target: ?x, m: 1.0) FOR ?x IN tracked;
BELIEF(message(request, ?_, charge)) & BELIEF(on_duty) => COMMIT(charge());
BELIEF(message(request, ?_, duty)) => COMMIT(SEQ(adoptBelief(on_duty), DELAY(60)));
PLAN charge() WHEN BELIEF(near(ball)) COST 1 { activate(STOP) }
PLAN charge() COST 2 { activate(SEEK_CHARGER(ref2: south)) }
"""
)


@pytest.mark.parametrize("reads_after_s", [0.0, 2.0, 60.0])
def test_a_choice_waits_for_the_first_reading_but_not_for_ever(reads_after_s: float) -> None:
    agent, body = choosing(BLIND)
    near = percepts(sees("ball", 0.8))
    off = replace(near, data=MutualDataStore({}))
    agent.cycle(0.0, [Term("message", ("request", "anna", "duty"))], off)
    agent.cycle(0.1, [ASKED], off)
    for tick in range(100):
        agent.cycle(0.2 + tick / 10, percepts=near if tick / 10 >= reads_after_s else off)
    assert begun(body) == [("SEEK_CHARGER", "south") if reads_after_s > FIRST_READING_S else ("STOP", "")]


def test_a_choice_waits_while_the_robot_senses_nothing() -> None:
    agent, body = choosing(south=3.0)
    body.senses = False
    agent.cycle(0.0, [ASKED])
    assert begun(body) == []
    body.senses = True
    agent.cycle(0.1)
    assert begun(body) == [("SEEK_CHARGER", "south")]


def test_a_plan_that_waits_for_the_body_outlasts_a_moment_without_senses() -> None:
    agent, body = choosing(south=3.0)
    body.is_busy = True
    agent.cycle(0.0, [ASKED])
    body.senses, known, body.measures = False, body.measures, {}
    agent.cycle(0.1)
    body.senses, body.measures, body.is_busy = True, known, False
    agent.cycle(0.2)
    assert begun(body) == [("SEEK_CHARGER", "south")]
