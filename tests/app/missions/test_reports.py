"""Robots' reports as they are recorded: what each costs, and which of them are not believed."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import event, select

from app.agents.agent_models import Reception
from app.domain.errors import NotFound
from app.domain.lifecycles.script import ask, order
from app.store import EventRow, GoalRow, MessageRow, ScriptRow, UnaskedRobotRow
from app.store.migrate import migrate
from planner import Fact
from robots.clock import ManualClock
from robots.wire import (
    Acknowledgement,
    Body,
    ControlVerb,
    ImageResult,
    Message,
    PacketReport,
    PacketState,
    Performative,
    ReadingResult,
    Refusal,
    StatusReport,
    SymbolicFact,
)
from tests.app.missions.mission_services import WORLD, MissionServices, services
from tests.app.sample_store import Store

STORE = Store()
PNG = b"\x89PNG\r\n\x1a\n and what follows"


class Mission:
    """The main job under way, with its robots' reports made by hand."""

    def __init__(self, services: MissionServices, clock: ManualClock) -> None:
        self.services = services
        self.clock = clock
        services.start_world()
        _, self.id = services.plans.approve(services.plan(), actor="operator")
        services.life.monitor(self.id)

    def agree(self) -> None:
        """Every robot accepts its script."""
        for script in self.services.scripts(self.id):
            agreed = Acknowledgement(script_id=script.id)
            self.services.record(self.message(script, agreed, in_reply_to=f"{script.id}:request"))

    def script(self, robot: str) -> ScriptRow:
        (script,) = (one for one in self.services.scripts(self.id) if one.robot == robot)
        return script

    def message(self, script: ScriptRow, body: Body, in_reply_to: str | None = None) -> Message:
        return Message(
            performative=Performative.AGREE if in_reply_to else Performative.INFORM,
            sender=script.robot,
            receiver="service",
            sent_at_s=self.clock.now_s(),
            in_reply_to=in_reply_to,
            body=body,
        )

    def packet_report(self, robot: str, packet: int, state: PacketState, at_s: float) -> Message:
        script = self.script(robot)
        packet_id = script.body["packets"][packet]["id"]
        report = PacketReport(script_id=script.id, packet_id=packet_id, state=state, at_s=at_s)
        return self.message(script, report)

    def report(self, robot: str, packet: int, state: PacketState, at_s: float) -> None:
        assert self.services.record(self.packet_report(robot, packet, state, at_s))

    def known(self, robot: str, packet: int) -> dict[str, Any]:
        script = self.script(robot)
        known: dict[str, Any] = script.packets.get(script.body["packets"][packet]["id"], {})
        return known


@pytest.fixture
def dispatched(tmp_path: Path) -> Iterator[Mission]:
    """No robot has answered yet."""
    clock = ManualClock()
    made = services(tmp_path, store=STORE, clock=clock)
    migrate(made.database)
    yield Mission(made, clock)
    made.close()


@pytest.fixture
def mission(dispatched: Mission) -> Mission:
    dispatched.agree()
    return dispatched


def test_a_script_that_was_on_its_way_when_the_mission_was_paused_is_paused(dispatched: Mission) -> None:
    dispatched.services.missions.pause(dispatched.id, "operator", "")
    dispatched.agree()
    assert {one.control for one in dispatched.services.scripts(dispatched.id)} == {"pause"}


def test_a_script_that_is_cancelled_before_its_robot_agrees_to_it_stays_cancelled(
    dispatched: Mission,
) -> None:
    """Also while the mission is paused: the order to pause would replace the one to cancel, which is not repeated."""
    dispatched.services.missions.pause(dispatched.id, "operator", "")
    dispatched.services.missions.cancel(dispatched.id, "operator", "")
    dispatched.services.life.monitor(dispatched.id)
    assert {one.control for one in dispatched.services.scripts(dispatched.id)} == {"cancel"}
    dispatched.agree()
    assert {one.control for one in dispatched.services.scripts(dispatched.id)} == {"cancel"}


@contextmanager
def statements(services: MissionServices) -> Iterator[list[str]]:
    """The SQL statements of the block."""
    sent: list[str] = []

    def note(_: object, __: object, statement: str, *___: object) -> None:
        sent.append(" ".join(statement.split()))

    event.listen(services.database.engine, "before_cursor_execute", note)
    yield sent
    event.remove(services.database.engine, "before_cursor_execute", note)


def reads(sent: list[str], table: str) -> int:
    return sum(one.startswith("SELECT") and f"FROM {table} " in one for one in sent)


def test_the_report_that_a_packet_has_finished_locks_the_world_once_and_reads_no_facts_that_are_in_memory(
    mission: Mission,
) -> None:
    mission.report("yard_1", 0, PacketState.RUNNING, 1.0)
    finished = mission.packet_report("yard_1", 0, PacketState.FINISHED, 9.0)
    with statements(mission.services) as sent:
        mission.services.record(finished)
    assert mission.known("yard_1", 0)["state"] == "finished"
    assert (reads(sent, "facts"), reads(sent, "unknowns")) == (0, 1)
    assert reads(sent, "worlds") == 2  # locked once; the count of what became free, for goals that wait
    assert reads(sent, "scripts") == 2


def test_the_report_that_a_packet_runs_reads_no_facts(mission: Mission) -> None:
    running = mission.packet_report("yard_1", 0, PacketState.RUNNING, 1.0)
    with statements(mission.services) as sent:
        mission.services.record(running)
    assert [reads(sent, table) for table in ("facts", "worlds", "plans")] == [0, 0, 0]


def test_a_packets_event_makes_the_facts_known_that_it_stands_for(mission: Mission) -> None:
    script = mission.script("yard_1")
    tracked = SymbolicFact(predicate="tracked", args=("yard_1", "yard_2"))
    packet = {**script.body["packets"][0], "events": {"met": [tracked.model_dump(mode="json")]}}
    with mission.services.database.write() as session:
        body = {**script.body, "packets": [packet, *script.body["packets"][1:]]}
        session.get_one(ScriptRow, script.id).body = body
    facts = partial(mission.services.read, lambda session: mission.services.core.facts.facts(session, WORLD))
    for event_name, is_known in (("away", False), ("met", True)):
        report = PacketReport(
            script_id=script.id,
            packet_id=packet["id"],
            state=PacketState.RUNNING,
            at_s=3.0,
            events=(event_name,),
        )
        mission.services.record(mission.message(script, report))
        assert (Fact("tracked", tracked.args) in facts()) is is_known


def test_a_report_that_a_newer_one_has_overtaken_is_not_believed(mission: Mission) -> None:
    mission.report("yard_1", 0, PacketState.RUNNING, 3.0)
    mission.report("yard_1", 0, PacketState.INITIALIZING, 1.0)
    assert (mission.known("yard_1", 0)["state"], mission.known("yard_1", 0)["at_s"]) == ("running", 3.0)
    mission.report("yard_1", 0, PacketState.PAUSED, 3.0)  # of the same instant, the last counts
    assert mission.known("yard_1", 0)["state"] == "paused"
    mission.report("yard_1", 0, PacketState.FINISHED, 2.0)
    assert mission.known("yard_1", 0)["state"] == "paused"


def test_the_end_of_a_packet_is_not_taken_back(mission: Mission) -> None:
    mission.report("yard_1", 0, PacketState.FINISHED, 3.0)
    mission.report("yard_1", 0, PacketState.RUNNING, 5.0)
    assert mission.known("yard_1", 0)["state"] == "finished"


def test_the_reason_of_a_refusal_outlasts_the_answer_to_a_status_query(dispatched: Mission) -> None:
    script = dispatched.script("yard_1")
    with dispatched.services.database.write() as session:
        ask(session.get_one(ScriptRow, script.id), "a query")
    refusal = Refusal(script_id=script.id, reason="the battery is low")
    dispatched.services.record(dispatched.message(script, refusal, in_reply_to=f"{script.id}:request"))
    assert dispatched.script("yard_1").question is None
    has_none = StatusReport(script_id=script.id, state=None, at_s=1.0)
    dispatched.services.record(dispatched.message(script, has_none, in_reply_to="a query"))
    assert dispatched.script("yard_1").detail == "the battery is low"


def test_a_robot_that_does_not_understand_a_status_query_is_not_asked_again(mission: Mission) -> None:
    script = mission.script("yard_1")

    def question() -> str | None:
        return mission.script("yard_1").question

    with mission.services.database.write() as session:
        ask(session.get_one(ScriptRow, script.id), "a query")
        asked = session.get_one(ScriptRow, mission.script("store_2").id)
        order(asked, ControlVerb.PAUSE)
    refusal = Refusal(script_id=script.id, reason="not understood: unknown kind status_query")
    mission.services.record(mission.message(script, refusal, in_reply_to="an earlier query"))
    assert question() == "a query"
    for query in ("a query", "a query"):
        mission.services.record(mission.message(script, refusal, in_reply_to=query))
    assert question() is None
    with mission.services.database.write() as session:
        order(session.get_one(ScriptRow, script.id), ControlVerb.PAUSE)
    for robot in ("yard_1", "store_2"):  # why is asked of the other alone
        refuser = mission.script(robot)
        unwilling = Refusal(script_id=refuser.id, reason="I never pause")
        mission.services.record(mission.message(refuser, unwilling, f"{refuser.id}:pause:1"))
    assert question() is None
    assert mission.script("store_2").question is not None
    told = mission.services.read(
        lambda session: session.scalars(
            select(EventRow.subject).where(EventRow.type == "robot.query_not_understood")
        ).all()
    )
    assert told == ["yard_1"]


@pytest.mark.parametrize("is_known_before", [True, False])
def test_a_robot_that_cannot_be_asked_and_refuses_to_cancel_what_it_never_took_does_not_have_it(
    dispatched: Mission, is_known_before: bool
) -> None:
    script = dispatched.script("yard_1")
    with dispatched.services.database.write() as session:
        order(session.get_one(ScriptRow, script.id), ControlVerb.CANCEL)
        if is_known_before:
            session.add(UnaskedRobotRow(world=WORLD, robot="yard_1", reason="unknown kind status_query"))
    refusal = Refusal(script_id=script.id, reason="busy, or not able to follow a control")
    dispatched.services.record(dispatched.message(script, refusal, f"{script.id}:cancel:1"))
    asked = dispatched.script("yard_1").question
    assert (asked is None) == is_known_before
    if asked is not None:
        unclear = Refusal(script_id=script.id, reason="not understood: unknown kind status_query")
        dispatched.services.record(dispatched.message(script, unclear, asked))
    script = dispatched.script("yard_1")
    assert (script.delivery, script.state) == ("withdrawn", "cancelled")
    assert (script.question, script.detail) == (None, "busy, or not able to follow a control")


def test_a_robot_that_refuses_to_cancel_what_it_carries_out_is_still_owed_an_end(mission: Mission) -> None:
    script = mission.script("yard_1")
    with mission.services.database.write() as session:
        order(session.get_one(ScriptRow, script.id), ControlVerb.CANCEL)
        session.add(UnaskedRobotRow(world=WORLD, robot="yard_1", reason="unknown kind status_query"))
    refusal = Refusal(script_id=script.id, reason="not now")
    mission.services.record(mission.message(script, refusal, f"{script.id}:cancel:1"))
    script = mission.script("yard_1")
    assert (script.delivery, script.state) == ("acknowledged", None)


def test_reports_that_arrive_together_are_recorded_in_one_transaction_in_their_order(
    mission: Mission,
) -> None:
    told = [
        mission.packet_report(robot, 0, state, at_s)
        for robot in ("yard_1", "store_2")
        for state, at_s in ((PacketState.RUNNING, 1.0), (PacketState.FINISHED, 9.0))
    ]
    mission.clock.advance(9.0)
    with statements(mission.services) as sent:
        receptions = mission.services.reports.record_all([*told, told[0]], WORLD)
    assert receptions == [Reception.RECORDED] * 4 + [Reception.IGNORED]
    assert [mission.known(robot, 0)["state"] for robot in ("yard_1", "store_2")] == ["finished"] * 2
    assert mission.known("yard_1", 0)["started_at_s"] == 1.0
    assert (reads(sent, "facts"), reads(sent, "missions")) == (0, 1)
    assert sum(one.startswith("BEGIN") for one in sent) == 1
    assert mission.services.reports.record_all(told, WORLD) == [Reception.IGNORED] * 4


def test_a_report_among_others_that_is_implausible_is_held_back_alone(mission: Mission) -> None:
    early = mission.packet_report("yard_1", 0, PacketState.FINISHED, 5000.0)
    running = mission.packet_report("store_2", 0, PacketState.RUNNING, 0.0)
    receptions = mission.services.reports.record_all([early, running], WORLD)
    assert receptions == [Reception.HELD_BACK, Reception.RECORDED]
    assert mission.known("yard_1", 0) == {}
    assert mission.known("store_2", 0)["state"] == "running"


def test_results_of_a_packets_end_are_kept_once_in_order_and_not_with_the_message(mission: Mission) -> None:
    taken = ImageResult(name="camera", of="bay_7", media_type="image/png", data=PNG)
    read = [ReadingResult(name="light_lx", of="bay_7", value=v, unit="lx") for v in (410.0, 411.0, 412.0)]
    script = mission.script("yard_1")
    packet_id = script.body["packets"][0]["id"]
    report = PacketReport(
        script_id=script.id, packet_id=packet_id, state=PacketState.FINISHED, at_s=9.0, results=(*read, taken)
    )
    said = mission.message(script, report)
    mission.report("yard_1", 0, PacketState.FINISHED, 9.0)  # of the same end, without what it brought
    assert mission.services.record(said)
    assert not mission.services.record(said)
    for again in (
        report,  # in another message, of a robot that has ended the packet once more
        report.model_copy(update={"state": PacketState.RUNNING}),
        report.model_copy(update={"packet_id": "unknown"}),
    ):
        assert mission.services.record(mission.message(script, again))
    rows = mission.services.missions.results(mission.id)
    assert [(row.kind, row.of, row.robot, row.packet_id, row.value) for row in rows] == [
        *(("reading", "bay_7", "yard_1", packet_id, value) for value in (410.0, 411.0, 412.0)),
        ("image", "bay_7", "yard_1", packet_id, None),
    ]
    assert mission.services.mission(mission.id).results == len(rows)
    image = rows[-1]
    assert mission.services.missions.result(mission.id, image.id).content == PNG
    with pytest.raises(NotFound):
        mission.services.missions.result(mission.id, "result-unknown")
    stored = mission.services.read(lambda session: session.get_one(MessageRow, f"{said.sender}/{said.id}"))
    assert [one["kind"] for one in stored.body["body"]["results"]] == ["reading"] * 3 + ["image"]
    assert "data" not in stored.body["body"]["results"][-1]


def test_the_goal_is_committed_while_its_mission_runs(mission: Mission) -> None:
    goal = mission.services.read(lambda session: session.get_one(GoalRow, "goal-1"))
    assert (goal.state, goal.mission_id) == ("committed", mission.id)
