"""`macta robot check`: prints what was found of each rule."""

import json
from contextlib import closing

from rich.console import Console
from rich.markup import escape

from app.cli.settings import settings_of
from app.domain.errors import Invalid
from app.trials.conformance.check import CheckRequest, RobotCheck
from app.trials.conformance.line import Line
from app.trials.conformance.mqtt import CheckedBroker
from app.trials.conformance.rules import Verdict
from robots.link.mqtt import Broker
from robots.wire import CONTRACT

COLOURS = {Verdict.KEPT: "green", Verdict.BROKEN: "bold red", Verdict.UNTRIED: "yellow"}


def check_robot(
    broker_url: str | None, world: str, robot: str, request: CheckRequest, *, as_json: bool
) -> int:
    """Check a robot and print the findings; returns the exit code.

    :raises Invalid: if no broker is set, or one of a package's link.
    :raises Unavailable: if the broker cannot be reached.
    """
    given = {} if broker_url is None else {"broker_url": broker_url}
    broker = settings_of(given, keeps_folder=False).broker()
    if not isinstance(broker, Broker):
        raise Invalid("--broker: set the broker's address, mqtt://HOST[:PORT] or mqtts://HOST[:PORT]")
    with closing(CheckedBroker(broker, world, robot)) as line:
        findings = RobotCheck(Line(line, world, robot), request).run()
    broken = sum(one.verdict is Verdict.BROKEN for one in findings)
    if as_json:
        rules = [
            {
                "rule": one.rule.value,
                "verdict": one.verdict.value,
                "detail": one.detail,
                "means": one.rule.words,
                "link": one.rule.link,
            }
            for one in findings
        ]
        print(json.dumps({"contract": CONTRACT, "robot": robot, "broken": broken, "rules": rules}, indent=2))
    else:
        console = Console(soft_wrap=True, highlight=False)
        for one in findings:
            why = f" ({one.detail})" if one.detail else ""
            colour = COLOURS[one.verdict]
            console.print(
                f"[{colour}]{one.verdict.value:8}[/] {one.rule.value:15} {escape(one.rule.words)}{escape(why)}"
            )
            if one.verdict is Verdict.BROKEN:
                console.print(f"         see {one.rule.link}")
        console.print(f"{robot}: {broken} of {len(findings)} rules broken")
    return 1 if broken else 0
