"""`macta robot check` on a real broker: with our own robots' software, and with the example for strangers."""

import json
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from typer.testing import CliRunner

from app.cli.main import app
from app.cli.trials.conformance.rules import Rule, Verdict
from examples.own_robot import OwnBody
from robots.adapters import ContractRobot, PacketForm
from robots.executive.agent import BehaviouralAgent
from robots.link.mqtt import Broker, RobotLink
from robots.physical.body import Pose
from robots.physical.profile import RobotProfile
from robots.wire import CONTRACT, Factsheet
from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.ports import free_port
from tests.robots.adapters.foreign_robot import Driver, Machine
from tests.scenarios.serving import command
from tests.waiting import until

EXAMPLE = Path(__file__).parents[3] / "examples" / "foreign_robot.py"
TICK_S = 0.05
SHEET = {"repertoire": ["NAVIGATE"], "speed_m_s": 1.0, "turn_rad_s": 1.0, "start": [0.0, 0.0, 0.0]}


@contextmanager
def ticking(world: str, port: int, make: Callable[[RobotLink], Callable[[str], None]]) -> Iterator[None]:
    """A robot in a thread; `make` gives what does a tick in the world's run."""
    ending = threading.Event()
    link = RobotLink(world, ["fred"], Broker.at(f"mqtt://127.0.0.1:{port}"))

    def drive() -> None:
        tick = make(link)
        while not ending.wait(TICK_S):
            if link.run is not None:
                tick(link.run)

    thread = threading.Thread(target=drive, name="fred")
    link.start()
    thread.start()
    try:
        yield
    finally:
        ending.set()
        thread.join()
        link.close()


def behavioural_agent(link: RobotLink) -> Callable[[str], None]:
    profile = RobotProfile(name="fred", start=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0), beacons={})
    agent = BehaviouralAgent(
        profile=profile,
        body=OwnBody(profile.start, {}, {}, link.clock),
        link=link,
        clock=link.clock,
        factsheet=Factsheet(repertoire=("TURN_LEFT",), speed_m_s=0.5, turn_rad_s=1.5),
    )
    return lambda run: agent.tick()


def contract_robot(link: RobotLink) -> Callable[[str], None]:
    machine = Machine(work_s=1.0)
    robot = ContractRobot(
        "fred",
        driver=Driver(machine),
        packets={"NAVIGATE": PacketForm()},
        link=link,
        clock=link.clock,
        factsheet=Factsheet(repertoire=("NAVIGATE",), speed_m_s=0.5, turn_rad_s=1.0),
    )

    def tick(run: str) -> None:
        robot.enter_run(run)
        machine.step(TICK_S)
        robot.tick()

    return tick


@contextmanager
def stranger(world: str, port: int) -> Iterator[None]:
    """The example as a process."""
    words = ["127.0.0.1", str(port), world, "fred", json.dumps(SHEET), "{}"]
    process = subprocess.Popen([sys.executable, str(EXAMPLE), *words])
    try:
        yield
    finally:
        process.kill()
        process.wait()


def listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def words_of(broker: Mosquitto, world: str, port: int, *words: str) -> list[str]:
    given = ["--broker", broker.url, "--robot", "fred", "--world", world, "--relay", str(port)]
    return ["robot", "check", *given, "--packet-s", "1", "--quiet-s", "0.5", *words]


@dataclass(frozen=True, slots=True)
class Outcome:
    """What one check printed, and its exit code."""

    printed: str
    complaints: str
    code: int


@pytest.fixture(scope="module")
def outcomes(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Mapping[str, Outcome]]:
    """The three checks, at the same time, each in a world and through a relay of its own."""
    ports = [free_port() for _ in range(3)]
    with mosquitto(tmp_path_factory.mktemp("broker")) as broker:
        others = [
            command(words, os.environ)
            for words in (
                words_of(broker, "check_b", ports[1], "--json", "--argument", "angle_rad=1.5"),
                words_of(broker, "check_c", ports[2], "--json"),
            )
        ]
        for port in ports[1:]:
            until(lambda port=port: listens(port), "the relay listens")  # type: ignore[misc]
        # Last, for it is patient for so long with a robot that does not start, and twice with one that stays away.
        first = command(words_of(broker, "check_a", ports[0], "--patience-s", "8"), os.environ)
        until(lambda: listens(ports[0]), "the relay listens")
        checks = [first, *others]
        with (
            stranger("check_a", ports[0]),
            ticking("check_b", ports[1], behavioural_agent),
            ticking("check_c", ports[2], contract_robot),
        ):
            printed = [check.communicate(timeout=120) for check in checks]
        yield {
            name: Outcome(text, complaints, check.returncode)
            for name, (text, complaints), check in zip(
                ("stranger", "agent", "adapter"), printed, checks, strict=True
            )
        }


@needs_mosquitto
@pytest.mark.parametrize("robot", ["agent", "adapter"])
def test_our_robots_keep_every_rule_on_a_real_broker(outcomes: Mapping[str, Outcome], robot: str) -> None:
    assert outcomes[robot].complaints == ""
    found = json.loads(outcomes[robot].printed)
    assert {one["rule"]: one["verdict"] for one in found["rules"]} == {one.value: "kept" for one in Rule}
    assert (found["contract"], found["robot"], found["broken"]) == (CONTRACT, "fred", 0)
    assert outcomes[robot].code == 0


@needs_mosquitto
def test_the_example_for_strangers_breaks_the_rules_that_its_page_names(
    outcomes: Mapping[str, Outcome],
) -> None:
    found = outcomes["stranger"]
    lines = found.printed.splitlines()
    verdicts = {words[1]: words[0] for line in lines if (words := line.split())[0] in list(Verdict)}
    assert verdicts.keys() == {rule.value for rule in Rule}
    broken = [rule for rule, verdict in verdicts.items() if verdict == "broken"]
    assert broken == ["status", "pauses", "stale", "reconnects"], found.printed
    assert "         see docs/robots.md#stale" in lines
    assert lines[-1] == f"fred: 4 of {len(Rule)} rules broken"
    assert found.code == 1


def test_a_relay_that_cannot_listen_is_an_error() -> None:
    def refusal(*words: str) -> str:
        result = CliRunner().invoke(app, ["robot", "check", "--robot", "fred", *words])
        assert result.exit_code == 2, result.output
        return result.output

    nobody = f"mqtt://127.0.0.1:{free_port()}"
    assert "--relay: '1884:x' is not PORT" in refusal("--broker", nobody, "--relay", "1884:x")
    with closing(socket.create_server(("127.0.0.1", 0))) as taken:
        port = str(taken.getsockname()[1])
        assert f"cannot listen at 127.0.0.1:{port}" in refusal("--broker", nobody, "--relay", port)
