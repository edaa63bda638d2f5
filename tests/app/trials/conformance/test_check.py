"""The check finds nothing wrong with a robot that keeps the contract, and the one rule that a robot breaks."""

from collections.abc import Mapping

import pytest

from app.trials.conformance.check import CheckRequest, RobotCheck
from app.trials.conformance.line import Line
from app.trials.conformance.rules import Finding, Rule, Verdict
from tests.app.trials.conformance.model_robot import ModelRobot

BY_HAND = {Rule.RECONNECTS}


def findings(robot: ModelRobot) -> Mapping[Rule, Finding]:
    found = RobotCheck(Line(robot, "check", "fred"), CheckRequest(tag="NAVIGATE")).run()
    assert [one.rule for one in found] == list(Rule)
    return {one.rule: one for one in found}


def those(found: Mapping[Rule, Finding], verdict: Verdict) -> set[Rule]:
    return {rule for rule, one in found.items() if one.verdict is verdict}


def test_a_robot_that_keeps_the_contract_breaks_no_rule() -> None:
    found = findings(ModelRobot())
    assert those(found, Verdict.BROKEN) == set(), found
    assert those(found, Verdict.UNTRIED) == BY_HAND, found


@pytest.mark.parametrize("rule", [rule for rule in Rule if rule not in BY_HAND])
def test_a_robot_that_breaks_one_rule_is_reported_for_that_alone(rule: Rule) -> None:
    found = findings(ModelRobot(breaks=rule))
    assert those(found, Verdict.BROKEN) == {rule}, [one for one in found.values() if one.detail]
    assert found[rule].detail
    for other in those(found, Verdict.UNTRIED):
        assert found[other].detail, other


class Absent(ModelRobot):
    """It is switched off."""

    def receive(self, timeout_s: float) -> list[None]:  # type: ignore[override]
        super().receive(timeout_s)
        return []


def test_of_a_robot_that_does_not_appear_nothing_else_is_said() -> None:
    found = findings(Absent())
    assert those(found, Verdict.BROKEN) == {Rule.CONNECTION, Rule.ANNOUNCES}
    assert len(those(found, Verdict.UNTRIED)) == len(Rule) - 2
