"""`macta robot check`: prints what was found of each rule."""

import json
from contextlib import ExitStack, closing

from rich.console import Console
from rich.markup import escape

from app.cli.settings import settings_of
from app.cli.trials.conformance.check import CheckRequest, RobotCheck
from app.cli.trials.conformance.line import Line
from app.cli.trials.conformance.mqtt import CheckedBroker
from app.cli.trials.conformance.relay import TcpRelay
from app.cli.trials.conformance.rules import Verdict
from app.domain.errors import Invalid
from robots.link.mqtt import Broker
from robots.wire import CONTRACT

COLOURS = {Verdict.KEPT: "green", Verdict.BROKEN: "bold red", Verdict.UNTRIED: "yellow"}


def check_robot(
    broker_url: str | None,
    world: str,
    robot: str,
    request: CheckRequest,
    *,
    relay: str | None = None,
    as_json: bool,
) -> int:
    """Check a robot and print the findings; returns the exit code.

    :param relay: `[HOST:]PORT` at which the robot connects, to be cut off; None: it is not cut off.
    :raises Invalid: if no broker is set, or one of a package's link.
    :raises Unavailable: if the broker cannot be reached, or the relay cannot listen.
    """
    at = None if relay is None else _address(relay)
    given = {} if broker_url is None else {"broker_url": broker_url}
    broker = settings_of(given, keeps_folder=False).broker()
    if not isinstance(broker, Broker):
        raise Invalid("--broker: set the broker's address, mqtt://HOST[:PORT] or mqtts://HOST[:PORT]")
    with ExitStack() as opened:
        passing = None if at is None else opened.enter_context(closing(TcpRelay(*at, broker)))
        line = opened.enter_context(closing(CheckedBroker(broker, world, robot)))
        findings = RobotCheck(Line(line, world, robot), request, relay=passing).run()
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


def _address(relay: str) -> tuple[str, int]:
    """Host and port; without a host only this machine reaches it."""
    host, _, port = relay.rpartition(":")
    if not (port.isascii() and port.isdigit() and int(port) < 65536):
        raise Invalid(f"--relay: {relay!r} is not PORT or HOST:PORT")
    return host.strip("[]") or "127.0.0.1", int(port)
