"""Who publishes in a robot's name where the broker lets it: dropped if the robot signs, else noticed if it shows."""

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import select

from app.agents import RobotBoard
from app.agents.impersonation import JUMPS, Impersonations, KeyFile, RobotWatch
from app.agents.signature_counters import SignatureCounters
from app.composition import Service
from app.domain.errors import Invalid
from app.store import Database, EventRow
from app.store.event_log import EventLog
from robots.clock import ManualClock
from robots.link.mqtt import Broker, FleetLink, ServiceLink
from robots.link.mqtt.session import Publication
from robots.link.mqtt.signature import Signer
from robots.wire import Body, MindTransferReport, Receipt, Telemetry
from robots.world import RobotSpec, WorldFile
from tests.app.stepped_clock import SteppedClock
from tests.mosquitto import mosquitto, needs_mosquitto
from tests.robots.link.mqtt.ends import RUN, received, report, telemetry
from tests.waiting import until

KEYS = {"fred": "a-key-of-fred"}


def external(world: WorldFile, *names: str) -> WorldFile:
    """The sample store as `hall`, with robots of these names for its own, that are not simulated."""
    specs = [
        RobotSpec.model_validate(dict(spec) | {"name": name, "external": True, "home": None})
        for name, spec in zip(names, world.robots, strict=False)
    ]
    parts = {field: getattr(world, field) for field in WorldFile.model_fields}
    return WorldFile(**parts | {"name": "hall", "robots": specs})


class Hall:
    """A world with two foreign robots, and what watches over them."""

    def __init__(self, world: WorldFile, database: Database) -> None:
        self.wall = SteppedClock()
        self.file = external(world, "fred", "ginger")
        self.board = RobotBoard.of({"hall": self.file}, clocks={"hall": ManualClock()}, low_battery=0.2)
        self.database = database
        self.impersonations = Impersonations(
            EventLog(database), worlds={"hall": self.file}, keys=lambda: KEYS, wall=self.wall
        )
        self.watch: RobotWatch = self.impersonations.watch("hall", self.board)

    def hear(self, robot: str, at_s: float, x_m: float, y_m: float = 1.0) -> None:
        self.watch.heard(robot, Telemetry(at_s=at_s, x_m=x_m, y_m=y_m, heading_rad=0.0))

    def noticed(self, robot: str) -> int:
        found = self.impersonations.of(robot)
        return 0 if found is None else found.count


@pytest.fixture
def hall(world_file: WorldFile, database: Database) -> Hall:
    return Hall(world_file, database)


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Broker]:
    with mosquitto(tmp_path / "broker") as broker:
        yield Broker.at(broker.url)


@needs_mosquitto
def test_only_what_a_robot_with_a_key_has_signed_arrives(hall: Hall, broker: Broker) -> None:
    service = ServiceLink("hall", ["fred", "ginger"], broker)
    service.guard(hall.watch)
    service.listen(hall.watch)
    signed = FleetLink("hall", ["fred", "ginger"], broker, run=RUN, keys=KEYS)
    service.start()
    signed.start()
    until(lambda: service.run == RUN and signed.connected)
    service.take_up(RUN)
    for robot in ("fred", "ginger"):
        signed.send(report(robot, "true"))
    assert {message.sender for message in received(service, 2)} == {"fred", "ginger"}
    signed.close()
    # An impostor at a broker that lets anybody in takes over both robots' connections.
    forged = FleetLink("hall", ["fred", "ginger"], broker, run=RUN)
    forged.start()
    until(lambda: forged.connected)
    forged.send(telemetry("fred", 3.0))
    for robot in ("fred", "ginger"):
        forged.send(report(robot, "forged"))
    assert [message.sender for message in received(service, 1)] == ["ginger"], (
        "it has no key, and is believed"
    )
    until(lambda: hall.noticed("fred") >= 3)  # its connection, its telemetry and its report
    assert hall.board.view("fred").telemetry is None
    assert hall.noticed("ginger") == 0
    forged.close()
    service.close()


def test_a_recorded_message_is_refused_after_a_restart_of_the_service(hall: Hall) -> None:
    counters = SignatureCounters(hall.database, wall=hall.wall)
    sign = Signer(KEYS["fred"], epoch_ns=lambda: 10**18)
    state = Publication(topic="macta/v1/hall/fred/state", payload=b"1", run=RUN)
    sheet = sign(replace(state, topic="macta/v1/hall/fred/factsheet", retain=True))
    earliest, recorded, later = sign(state), sign(state), sign(state)
    assert all(hall.watch.admits("fred", one) for one in (sheet, earliest, recorded))
    counters.save("hall", hall.watch.accepted)
    assert hall.watch.admits("fred", later)
    counters.save("hall", hall.watch.accepted)  # too soon: not written
    hall.wall.advance(6.0)
    counters.save("hall", hall.watch.accepted)
    restarted = SignatureCounters(hall.database, wall=hall.wall)
    watch = hall.impersonations.watch("hall", hall.board, restarted.load("hall"))
    assert not any(watch.admits("fred", one) for one in (earliest, recorded))
    assert hall.noticed("fred") == 2
    assert watch.admits("fred", sheet), "it is retained"
    assert watch.admits("fred", sign(state))
    assert not restarted.load("elsewhere")


def test_software_that_stands_by_for_a_simulated_robot_may_answer_what_moves_minds_alone(
    world_file: WorldFile, database: Database, hall: Hall
) -> None:
    watch = Impersonations(
        EventLog(database), worlds={"hall": world_file}, keys=lambda: {"yard_1": "a-key"}, wall=hall.wall
    ).watch("hall", hall.board)
    sign = Signer("a-key", epoch_ns=lambda: 10**18)

    def said(body: Body) -> Publication:
        message = report("yard_1", "m1").model_copy(update={"body": body})
        topic = "macta/v1/hall/yard_1/state"
        return Publication(topic=topic, payload=message.model_dump_json().encode(), run=RUN)

    taken = said(MindTransferReport(fence=1, digest="", number=0))
    assert watch.admits("yard_1", sign(taken))
    assert not watch.admits("yard_1", Signer("another")(taken))
    assert not watch.admits("yard_1", sign(said(Receipt())))
    assert not watch.admits("yard_1", sign(replace(taken, payload=b"1")))
    assert watch.admits("yard_1", said(Receipt())), "the fleet, which simulates it, does not sign"


def test_telemetry_that_goes_to_and_fro_is_noticed(hall: Hall) -> None:
    for jump in range(JUMPS):
        hall.hear("ginger", 0.1 * jump, 1.0 if jump % 2 else 6.0)
    assert hall.noticed("ginger") == 0
    hall.hear("ginger", 0.1 * JUMPS, 1.0 if JUMPS % 2 else 6.0)
    assert hall.noticed("ginger") == 1
    found = hall.impersonations.of("ginger")
    assert found is not None
    assert "(1.0, 1.0) and (6.0, 1.0)" in found.reason


def test_clocks_that_go_to_and_fro_excuse_nothing(hall: Hall) -> None:
    for turn in range(2 * JUMPS):
        hall.hear("ginger", turn, 1.0)
        hall.hear("ginger", turn + 5000.0, 6.0)
    assert hall.noticed("ginger") > 0


@pytest.mark.parametrize(
    "course",
    [
        [(at_s, 1.0 + 0.5 * at_s) for at_s in range(10)],  # it drives
        [(at_s, 1.0 + (at_s >= 5) * 6.0) for at_s in range(10)],  # it corrects its estimate once
        [(at_s, 1.0 + 3.0 * at_s) for at_s in range(6)],  # it slides, and does not return
        [(10.0 * at_s, 1.0 + 5.0 * (at_s % 2)) for at_s in range(20)],  # it is heard seldom
        [(at_s, 1.0 + 0.9 * (at_s % 2)) for at_s in range(20)],  # its estimate is noisy
    ],
)
def test_a_robot_alone_is_not_suspected(hall: Hall, course: list[tuple[float, float]]) -> None:
    for at_s, x_m in course:
        hall.hear("ginger", at_s, x_m)
    assert hall.noticed("ginger") == 0


def test_jumps_long_apart_are_not_counted_together(hall: Hall) -> None:
    for turn in range(3 * JUMPS):
        hall.hear("ginger", turn, 1.0 + 5.0 * (turn % 2))
        hall.wall.advance(40.0)
    assert hall.noticed("ginger") == 0


def test_events_are_bounded(hall: Hall) -> None:
    def recorded() -> list[int]:
        hall.impersonations.record(hall.database, "hall")
        with hall.database.read() as session:
            query = select(EventRow).where(EventRow.type == "robot.impersonated").order_by(EventRow.seq)
            return [row.data["count"] for row in session.scalars(query)]

    for _ in range(5):
        hall.impersonations.note("hall", "fred", "a message is not signed")
    assert hall.impersonations.has_news("hall")
    assert not hall.impersonations.has_news("elsewhere")
    assert recorded() == [5]
    hall.impersonations.note("hall", "fred", "a message is not signed")
    assert not hall.impersonations.has_news("hall")
    assert recorded() == [5]
    hall.wall.advance(61.0)
    assert recorded() == [5, 1]


def test_the_file_of_keys_is_read_again(tmp_path: Path) -> None:
    wall = SteppedClock()
    path = tmp_path / "robot_keys.json"
    path.write_text(json.dumps(KEYS))
    keys = KeyFile(path, wall=wall)
    assert keys.read() == KEYS
    for text, known in (('{"fred": "other"}', {"fred": "other"}), ("{", {"fred": "other"}), ("{}", {})):
        (tmp_path / "new").write_text(text)
        (tmp_path / "new").replace(path)
        wall.advance(2.0)
        assert keys.read() == known
    with pytest.raises(Invalid, match="MACTA_ROBOT_KEYS"):
        KeyFile(tmp_path / "missing")


def test_clients_see_who_is_impersonated(
    api: TestClient, service: Service, follow: Callable[..., dict[str, Any]]
) -> None:
    assert api.get("/v1/robots/yard_1").json()["impersonation"] is None
    service.impersonations.note("sample_store", "yard_1", "a message is not signed")
    shown = api.get("/v1/robots/yard_1").json()["impersonation"]
    assert (shown["count"], shown["reason"]) == (1, "a message is not signed")
    until(lambda: not service.impersonations.has_news("sample_store"), "its event is recorded")
