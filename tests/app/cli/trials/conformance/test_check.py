"""The check finds nothing wrong with a robot that keeps the contract, and the one rule that a robot breaks."""

from collections.abc import Mapping
from typing import Any

import pytest

from app.cli.trials.conformance.check import CheckRequest, RobotCheck
from app.cli.trials.conformance.line import Line
from app.cli.trials.conformance.rules import Finding, Rule, Verdict
from tests.app.cli.trials.conformance.model_robot import ModelRobot

CUT_OFF = {Rule.LAST_WILL, Rule.RECONNECTS}
"""Tried by cutting the robot off."""


def findings(robot: ModelRobot, *, has_relay: bool = True) -> Mapping[Rule, Finding]:
    line = Line(robot, "check", "fred")
    found = RobotCheck(line, CheckRequest(tag="NAVIGATE"), relay=robot if has_relay else None).run()
    assert [one.rule for one in found] == list(Rule)
    return {one.rule: one for one in found}


def those(found: Mapping[Rule, Finding], verdict: Verdict) -> set[Rule]:
    return {rule for rule, one in found.items() if one.verdict is verdict}


def test_a_robot_that_keeps_the_contract_breaks_no_rule() -> None:
    found = findings(ModelRobot())
    assert those(found, Verdict.BROKEN) == set(), found
    assert those(found, Verdict.UNTRIED) == set(), found


@pytest.mark.parametrize("rule", list(Rule))
def test_a_robot_that_breaks_one_rule_is_reported_for_that_alone(rule: Rule) -> None:
    found = findings(ModelRobot(breaks=rule))
    assert those(found, Verdict.BROKEN) == {rule}, [one for one in found.values() if one.detail]
    assert found[rule].detail
    for other in those(found, Verdict.UNTRIED):
        assert found[other].detail, other


@pytest.mark.parametrize(
    ("connections", "has_relay", "why"),
    [(1, False, "--relay"), (0, True, "did not connect through the relay at 127.0.0.1:1884")],
)
def test_what_needs_a_robot_that_was_cut_off_is_untried_with_the_reason(
    connections: int, has_relay: bool, why: str
) -> None:
    found = findings(ModelRobot(connections=connections), has_relay=has_relay)
    assert those(found, Verdict.BROKEN) == set(), found
    assert those(found, Verdict.UNTRIED) == CUT_OFF
    assert all(why in found[rule].detail for rule in CUT_OFF)


class Unpausable(ModelRobot):
    """It refuses to pause, with a reason."""

    def _follow(self, script: str, verb: str, number: int) -> str | None:
        return "I never pause" if verb == "pause" else super()._follow(script, verb, number)


def test_a_refusal_to_pause_a_script_under_way_breaks_the_rule() -> None:
    found = findings(Unpausable())
    assert those(found, Verdict.BROKEN) == {Rule.PAUSES}
    assert "I never pause" in found[Rule.PAUSES].detail
    assert those(found, Verdict.UNTRIED) == {Rule.RESUMES, Rule.ORDER_NUMBERS}


class Waiting(ModelRobot):
    """No clearance makes it go on."""

    def _obey(self, script: str, body: dict[str, Any]) -> str | None:
        return None if body["kind"] == "clearance" else super()._obey(script, body)


@pytest.mark.parametrize(
    ("robot", "fault"),
    [
        (ModelRobot(breaks=Rule.CLEARANCE), "it began before the clearance"),
        (Waiting(), "it did not go on after the clearance"),
    ],
)
def test_it_is_said_how_a_robot_disregards_a_clearance(robot: ModelRobot, fault: str) -> None:
    found = findings(robot)[Rule.CLEARANCE]
    assert (found.verdict, found.detail) == (Verdict.BROKEN, fault)


class Forgetful(ModelRobot):
    """It begins its packet again once it is connected again."""

    def restore(self) -> None:
        super().restore()
        if self._job:
            self._job["left_s"] = None
            self._job["step"] = 0


class Gone(ModelRobot):
    """It does not come back."""

    def restore(self) -> None:
        pass


@pytest.mark.parametrize(
    ("robot", "fault"), [(Forgetful(), "began a packet twice"), (Gone(), "did not say again")]
)
def test_a_robot_that_forgets_or_stays_away_when_it_is_cut_off_breaks_that_rule(
    robot: ModelRobot, fault: str
) -> None:
    found = findings(robot)
    assert those(found, Verdict.BROKEN) == {Rule.RECONNECTS}
    assert fault in found[Rule.RECONNECTS].detail


class Absent(ModelRobot):
    """It is switched off."""

    def receive(self, timeout_s: float) -> list[None]:  # type: ignore[override]
        super().receive(timeout_s)
        return []


def test_of_a_robot_that_does_not_appear_nothing_else_is_said() -> None:
    found = findings(Absent())
    assert those(found, Verdict.BROKEN) == {Rule.CONNECTION, Rule.ANNOUNCES}
    assert len(those(found, Verdict.UNTRIED)) == len(Rule) - 2
