"""A robot that is driven packet by packet keeps the contract with the service."""

import pytest

from robots.adapters import Progress, ProgressState
from robots.adapters.contract_robot import MemoryUnusable
from robots.adapters.script_run import STOP_S
from robots.executive.hand_over import pieces_of
from robots.wire import (
    Acknowledgement,
    BehaviourScript,
    Control,
    ControlVerb,
    Factsheet,
    FactsheetAnswer,
    FactsheetState,
    FailureCategory,
    Message,
    MindOrder,
    MindOrderReport,
    MindTransfer,
    MindTransferReport,
    MindVerb,
    PacketState,
    Performative,
    ReadingResult,
    Refusal,
    Retune,
    ScriptState,
    SetPoint,
    SetPointRefusal,
    StatusQuery,
    StatusReport,
    TuningReport,
)
from tests.robots.adapters.foreign_robot import (
    ALL_DONE,
    CANCELLED,
    SensingRobot,
    Stage,
    fact,
    fetch,
    packet,
    script,
)

DRIVE = packet("a1", "NAVIGATE", ref2="bay_1", achieves=("near(carl, bay_1)",))
CANCEL, PAUSE, RESUME = ControlVerb.CANCEL, ControlVerb.PAUSE, ControlVerb.RESUME


def ordered(stage: Stage, verb: ControlVerb, number: int = 0, name: str = "s1") -> Message:
    performative = Performative.CANCEL if verb is CANCEL else Performative.REQUEST
    return stage.service.send(Control(script_id=name, verb=verb, number=number), performative)


def status(stage: Stage, name: str = "s1") -> StatusReport:
    query = stage.service.send(StatusQuery(script_id=name), Performative.QUERY)
    stage.run_for(1)
    answer = stage.service.answer(query)
    assert isinstance(answer, StatusReport)
    return answer


def refusal(stage: Stage, one: BehaviourScript) -> str:
    request = stage.order(one)
    stage.run_for(1)
    answer = stage.service.answer(request)
    assert isinstance(answer, Refusal), answer
    return answer.reason


def under_way(stage: Stage, *packets: object) -> None:
    """The script s1 has begun its first packet."""
    stage.order(script(*packets or (DRIVE,)))  # type: ignore[arg-type]
    assert stage.run_until(lambda: ("a1", PacketState.RUNNING) in stage.service.packets)


def test_packets_are_carried_out_in_order_and_told_with_their_effects() -> None:
    stage = Stage()
    order = fetch()
    request = stage.order(order)
    stage.clear(order, "a9")
    assert stage.run_until(lambda: bool(stage.service.ends))
    assert isinstance(stage.service.answer(request), Acknowledgement)
    assert stage.machine.log == ["s1/a1", "s1/a2", "s1/a3"]
    assert stage.service.packets == ALL_DONE
    told = {
        one.packet_id: one.perceived for one in stage.service.reports if one.state is PacketState.FINISHED
    }
    assert told == {one.id: one.achieves for one in order.packets}
    (end,) = stage.service.ends
    assert (end.state, end.category) == (ScriptState.FINISHED, None)


def test_what_the_driver_perceives_is_told_instead_of_what_the_packet_is_for() -> None:
    stage = Stage()
    stage.driver.perceived = (fact("near(carl, bay_2)"),)
    reading = ReadingResult(name="temperature", of="bay_2", value=4.0)
    stage.driver.results = (reading,)
    under_way(stage)
    stage.driver.events = ("slipped",)
    assert stage.run_until(lambda: bool(stage.service.ends))
    finished = stage.service.reports[-1]
    assert finished.perceived == (fact("near(carl, bay_2)"),)
    assert finished.results == (reading,)
    assert [one.state for one in stage.service.reports if one.events == ("slipped",)] == [PacketState.RUNNING]


@pytest.mark.parametrize(
    ("one", "why"),
    [
        (
            script(packet("a1", "FLY")),
            "FLY is not in the repertoire of carl; it has: DOCK, NAVIGATE, RELEASE2",
        ),
        (script(packet("a1", "NAVIGATE")), "NAVIGATE lacks the argument ref2"),
        (
            script(packet("a1", "NAVIGATE", ref2="moon")),
            "NAVIGATE: ref2 = moon is not known to carl; known: bay_1, bay_2, yard",
        ),
        (script(DRIVE, robot="ginger"), "script s1 is for ginger, this is carl"),
        (script(DRIVE, DRIVE), "script s1 has two packets a1"),
        (
            script(packet("a1", "RELEASE2", awaits=("clear(bay_1)",))),
            "carl cannot sense clear(bay_1), which RELEASE2 (a1) awaits; it senses: nothing",
        ),
    ],
)
def test_a_script_that_it_cannot_carry_out_is_refused_with_the_reason(one: BehaviourScript, why: str) -> None:
    stage = Stage()
    assert refusal(stage, one) == why
    assert stage.machine.log == []


def test_a_driver_may_object_to_a_script() -> None:
    stage = Stage(objection=lambda script: f"the battery is too low for {script.id}")
    assert refusal(stage, script(DRIVE)) == "the battery is too low for s1"


def test_a_script_of_another_mission_is_refused_while_one_is_under_way() -> None:
    stage = Stage()
    under_way(stage)
    assert refusal(stage, script(DRIVE, name="s2", mission="m2")) == "carl is busy with script s1"


def test_a_later_revision_supersedes_the_script_and_begins_when_the_robot_stands() -> None:
    stage = Stage()
    stage.machine.stops_in_s = 2.0
    under_way(stage)
    later = script(packet("a1", "NAVIGATE", ref2="yard"), name="s2", revision=2)
    request = stage.order(later)
    stage.run_for(1)
    assert isinstance(stage.service.answer(request), Acknowledgement)
    assert stage.machine.log == ["s1/a1"]
    assert stage.run_until(lambda: len(stage.service.ends) == 2)
    first, second = stage.service.ends
    assert (first.script_id, first.state, first.category) == ("s1", *CANCELLED)
    assert first.detail == "superseded by revision 2 of its mission"
    assert (second.script_id, second.state) == ("s2", ScriptState.FINISHED)
    assert stage.machine.log == ["s1/a1", "s2/a1"]
    assert "stale" in refusal(stage, script(DRIVE, name="s0", revision=1))


def test_a_packet_waits_for_its_clearance_and_says_so() -> None:
    stage = Stage()
    order = fetch()
    stage.order(order)
    assert stage.run_until(lambda: ("a2", PacketState.INITIALIZING) in stage.service.packets)
    stage.run_for(20)
    assert stage.machine.log == ["s1/a1"]
    now = status(stage)
    assert (now.state, now.packet_id, now.packet_state) == (
        ScriptState.RUNNING,
        "a2",
        PacketState.INITIALIZING,
    )
    assert now.detail == "waits for clearance: a9"
    stage.clear(order, "a9")
    assert stage.run_until(lambda: bool(stage.service.ends))
    assert stage.service.packets == ALL_DONE


def test_a_packet_without_its_clearance_fails_in_time() -> None:
    stage = Stage()
    stage.order(script(packet("a1", "DOCK", object="o", after=("a9",), wait_timeout_s=10)))
    assert stage.run_until(lambda: bool(stage.service.ends), limit_s=12)
    (end,) = stage.service.ends
    assert (end.state, end.category) == (ScriptState.FAILED, FailureCategory.DEADLINE)
    assert end.detail == "DOCK could not start within 10 s: the robot waits for clearance: a9"
    assert stage.machine.log == []


def test_a_robot_that_senses_waits_until_it_does() -> None:
    stage = Stage(driver=SensingRobot)
    stage.order(script(packet("a1", "DOCK", object="o", awaits=("in(o, bay_1)",))))
    stage.run_for(10)
    assert stage.machine.log == []
    assert status(stage).detail == "does not sense in(o, bay_1)"
    assert isinstance(stage.driver, SensingRobot)
    stage.driver.sensed.add("in(o, bay_1)")
    assert stage.run_until(lambda: bool(stage.service.ends))
    assert stage.service.ends[0].state is ScriptState.FINISHED


def test_what_a_robot_never_senses_fails_its_packet_as_a_changed_world() -> None:
    stage = Stage(driver=SensingRobot)
    stage.order(script(packet("a1", "DOCK", object="o", awaits=("in(o, bay_1)",), wait_timeout_s=5)))
    assert stage.run_until(lambda: bool(stage.service.ends), limit_s=8)
    assert stage.service.ends[0].category is FailureCategory.WORLD_CHANGED


def test_a_failure_of_the_robot_fails_packet_and_script_with_its_reason() -> None:
    stage = Stage()
    under_way(stage)
    stage.machine.failing["s1/a1"] = "was given up: the way is blocked"
    assert stage.run_until(lambda: bool(stage.service.ends))
    (end,) = stage.service.ends
    assert (end.state, end.category) == (ScriptState.FAILED, FailureCategory.ROBOT)
    assert end.detail == "NAVIGATE was given up: the way is blocked"
    assert stage.service.packets[-1] == ("a1", PacketState.FAILED)


def test_a_packet_that_the_driver_cannot_begin_has_failed_and_never_ran() -> None:
    stage = Stage()
    stage.machine.refuses = "was rejected by the robot"
    stage.order(script(DRIVE))
    assert stage.run_until(lambda: bool(stage.service.ends))
    assert stage.service.packets == [("a1", PacketState.INITIALIZING), ("a1", PacketState.FAILED)]
    assert stage.service.ends[0].detail == "NAVIGATE was rejected by the robot"


def overdue(*, stops_in_s: float) -> Stage:
    """A robot that is being stopped, for its packet takes too long."""
    stage = Stage()
    stage.machine.work_s = 1e9
    stage.machine.stops_in_s = stops_in_s
    stage.order(script(packet("a1", "RELEASE2", timeout_s=10)))
    assert stage.run_until(lambda: "cancel" in stage.driver.calls, limit_s=20)
    return stage


def test_a_packet_that_takes_too_long_is_cancelled_and_fails_once_the_robot_stands() -> None:
    stage = overdue(stops_in_s=3.0)
    assert not stage.service.ends
    assert stage.run_until(lambda: bool(stage.service.ends), limit_s=10)
    assert stage.machine.current is None
    assert stage.service.ends[0].category is FailureCategory.DEADLINE
    assert stage.service.ends[0].detail == "RELEASE2 did not end within 10 s"


def test_cancelled_is_reported_once_the_robot_stands() -> None:
    stage = Stage()
    stage.machine.stops_in_s = 5.0
    under_way(stage)
    request = ordered(stage, CANCEL)
    stage.run_for(1)
    assert isinstance(stage.service.answer(request), Acknowledgement)
    assert not stage.service.ends
    assert stage.run_until(lambda: bool(stage.service.ends), limit_s=10)
    assert stage.machine.current is None
    assert (stage.service.ends[0].state, stage.service.ends[0].category) == CANCELLED


def test_a_packet_that_finishes_while_it_is_cancelled_has_finished() -> None:
    stage = Stage()
    under_way(stage, DRIVE, packet("a2", "RELEASE2"))
    ordered(stage, CANCEL)
    stage.machine.left_s = 0.0
    assert stage.run_until(lambda: bool(stage.service.ends))
    assert stage.service.packets[-1] == ("a1", PacketState.FINISHED)
    assert stage.service.ends[0].state is ScriptState.CANCELLED
    assert stage.machine.log == ["s1/a1"]


def test_a_packet_that_finishes_while_it_is_stopped_for_its_time_has_finished() -> None:
    stage = overdue(stops_in_s=5.0)
    stage.machine.left_s = 0.0
    assert stage.run_until(lambda: bool(stage.service.ends))
    assert stage.service.packets[-1] == ("a1", PacketState.FINISHED)
    assert stage.service.ends[0].state is ScriptState.FINISHED


def test_a_robot_that_does_not_stop_has_failed() -> None:
    stage = Stage()
    stage.machine.work_s = 1e9
    stage.machine.stops_in_s = 1e9
    under_way(stage)
    ordered(stage, CANCEL)
    assert stage.run_until(lambda: bool(stage.service.ends), limit_s=STOP_S + 5)
    assert stage.service.ends[0].state is ScriptState.FAILED
    assert "may still move" in stage.service.ends[0].detail


def test_a_cancel_may_arrive_before_its_script() -> None:
    stage = Stage()
    request = ordered(stage, CANCEL)
    stage.run_for(1)
    assert isinstance(stage.service.answer(request), Acknowledgement)
    assert [(end.script_id, end.state) for end in stage.service.ends] == [("s1", ScriptState.CANCELLED)]
    assert refusal(stage, script(DRIVE)) == "stale: script s1 was cancelled before it arrived"


def test_orders_on_scripts_that_it_does_not_have_are_refused() -> None:
    stage = Stage()
    requests = [ordered(stage, PAUSE), stage.clear(fetch(), "a9")]
    stage.run_for(1)
    for request in requests:
        answer = stage.service.answer(request)
        assert isinstance(answer, Refusal)
        assert answer.reason == "no script s1 here"


def test_a_paused_robot_stands_and_its_time_does_not_run() -> None:
    stage = Stage()
    under_way(stage, packet("a1", "RELEASE2", timeout_s=10))
    ordered(stage, PAUSE, 1)
    stage.run_for(60)
    assert stage.machine.paused
    assert stage.service.packets[-1] == ("a1", PacketState.PAUSED)
    assert status(stage).state is ScriptState.PAUSED
    ordered(stage, RESUME, 2)
    assert stage.run_until(lambda: bool(stage.service.ends), limit_s=10)
    assert stage.service.ends[0].state is ScriptState.FINISHED
    assert stage.driver.calls == ["start", "pause", "resume"]


def test_of_two_orders_the_one_with_the_greater_number_holds() -> None:
    stage = Stage()
    under_way(stage)
    ordered(stage, RESUME, 2)
    late = ordered(stage, PAUSE, 1)
    stage.run_for(1)
    answer = stage.service.answer(late)
    assert isinstance(answer, Refusal)
    assert answer.reason == "order 1 to pause script s1 was overtaken by order 2"
    assert status(stage).order == 2
    assert not stage.machine.paused


def test_a_paused_script_can_be_cancelled() -> None:
    stage = Stage()
    under_way(stage)
    ordered(stage, PAUSE, 1)
    stage.run_for(2)
    ordered(stage, CANCEL, 2)
    assert stage.run_until(lambda: bool(stage.service.ends), limit_s=5)
    assert (stage.service.ends[0].state, stage.service.ends[0].category) == CANCELLED


def test_a_script_that_waits_is_cancelled_at_once() -> None:
    stage = Stage()
    stage.order(script(packet("a1", "RELEASE2", after=("a9",))))
    stage.run_for(2)
    ordered(stage, CANCEL)
    stage.run_for(1)
    assert stage.service.ends[0].state is ScriptState.CANCELLED
    assert stage.driver.calls == []


def test_reports_are_repeated_until_their_receipts_arrive() -> None:
    stage = Stage(receipts=False)
    under_way(stage)
    stage.run_for(10)
    heard = len(stage.service.heard)
    stage.service.heard.clear()
    stage.run_for(30)
    again = [message for message in stage.service.heard if message.body.kind == "packet_report"]
    assert len({message.id for message in again}) >= 1 < heard
    stage.service.receipts = True
    stage.run_for(30)
    stage.service.heard.clear()
    stage.run_for(60)
    assert [one for one in stage.service.heard if one.body.kind.endswith("report")] == []


def test_the_same_script_in_another_message_runs_once() -> None:
    stage = Stage()
    under_way(stage)
    again = stage.order(script(DRIVE))
    assert stage.run_until(lambda: bool(stage.service.ends))
    stage.order(script(DRIVE))
    stage.run_for(10)
    assert isinstance(stage.service.answer(again), Acknowledgement)
    assert stage.machine.log == ["s1/a1"]


def test_what_only_robots_with_patterns_can_do_is_declined() -> None:
    stage = Stage()
    tuned = stage.service.send(Retune(version=3, tuning={}))
    driven = stage.service.send(SetPoint(driver="op", number=1, valid_s=1.0))
    moved = stage.service.send(MindOrder(verb=MindVerb.REST, fence=1))
    handed = stage.service.send(MindTransfer(fence=1, mind=pieces_of("{}")[0]))
    stage.run_for(1)
    stays, kept = stage.service.answer(moved), stage.service.answer(handed)
    assert isinstance(kept, MindTransferReport)
    assert kept.reason == "carl is driven packet by packet and takes no minds"
    assert isinstance(stays, MindOrderReport)
    assert stays.reason == "carl has a body of its own"
    report, refused = stage.service.answer(tuned), stage.service.answer(driven)
    assert isinstance(report, TuningReport)
    assert report.reason == "carl has no patterns to tune"
    assert isinstance(refused, SetPointRefusal)
    assert (refused.driver, refused.reason) == ("op", "carl cannot be driven by an operator")


def test_telemetry_shows_the_robot_and_what_it_does() -> None:
    stage = Stage()
    under_way(stage)
    stage.driver.x_m = 2.5
    stage.run_for(0.5)
    told = stage.service.telemetry[-1]
    assert (told.x_m, told.battery, told.script_id, told.packet_tag) == (2.5, 0.75, "s1", "NAVIGATE")
    assert told.packet_state is PacketState.RUNNING
    stage.run_until(lambda: bool(stage.service.ends))
    stage.run_for(1)
    assert stage.service.telemetry[-1].script_id is None


FACTS = Factsheet(repertoire=("NAVIGATE",), speed_m_s=1.0, turn_rad_s=1.0)


def test_the_factsheet_is_told_once_and_again_when_it_has_changed() -> None:
    stage = Stage(factsheet=FACTS)
    stage.run_for(2)
    stage.restart()
    stage.run_for(2)
    stage.factsheet = FACTS.model_copy(update={"speed_m_s": 0.5})
    stage.restart()
    stage.run_for(2)
    told = [one.body for one in stage.service.heard if isinstance(one.body, Factsheet)]
    assert [(one.number, one.speed_m_s) for one in told] == [(0, 1.0), (1, 0.5)]


def test_what_becomes_of_the_factsheet_is_known() -> None:
    stage = Stage(factsheet=FACTS)
    answer = FactsheetAnswer(state=FactsheetState.REFUSED, reason="another robot stands there")
    stage.service.send(answer, Performative.REFUSE)
    stage.run_for(1)
    assert stage.robot.factsheet_answer == answer


def test_nothing_is_answered_or_begun_while_the_memory_cannot_be_saved() -> None:
    stage = Stage()
    stage.flash.full = True
    stage.order(script(DRIVE))
    stage.run_for(30)
    assert stage.service.heard == []
    assert stage.machine.log == []
    assert "no space left" in stage.robot.complaint
    stage.flash.full = False
    assert stage.run_until(lambda: bool(stage.service.ends))
    assert stage.robot.complaint == ""
    assert stage.machine.log == ["s1/a1"]


def test_a_memory_that_cannot_be_saved_is_saved_as_soon_as_it_can_be() -> None:
    stage = Stage()
    stage.run_for(1)
    stage.flash.full = True
    stage.robot.enter_run("run-2")
    stage.run_for(1)
    assert "no space left" in stage.robot.complaint
    stage.flash.full = False
    stage.run_for(1)
    assert stage.robot.complaint == ""
    assert "run-2" in str(stage.flash.text)


def test_a_cancel_is_followed_even_while_the_memory_cannot_be_saved() -> None:
    stage = Stage()
    under_way(stage)
    stage.flash.full = True
    stage.service.send(Control(script_id="s1", verb=CANCEL), Performative.CANCEL, repeat=True)
    stage.run_for(2)
    assert stage.machine.current is None
    assert not stage.service.ends
    stage.flash.full = False
    assert stage.run_until(lambda: bool(stage.service.ends))


def test_in_a_new_run_of_the_world_the_robot_stops_and_forgets() -> None:
    stage = Stage()
    under_way(stage)
    stage.robot.enter_run("run-2")
    stage.run_for(2)
    assert stage.machine.current is None
    stage.service.heard.clear()
    stage.order(script(DRIVE, packet("a2", "RELEASE2"), name="s2", mission="m2"))
    assert stage.run_until(lambda: bool(stage.service.ends))
    assert [end.state for end in stage.service.ends] == [ScriptState.FINISHED]


def test_after_a_restart_in_another_run_the_robot_stops_and_forgets() -> None:
    stage = Stage()
    stage.machine.stops_in_s = 1.0
    under_way(stage)
    stage.run_name = "run-2"
    stage.service.heard.clear()
    stage.restart()
    stage.run_for(5)
    assert stage.machine.current is None
    assert stage.service.ends == []
    assert stage.machine.log == ["s1/a1"]


@pytest.mark.parametrize("text", ["", "{", '{"robot": "carl", "runs": [1]}'])
def test_a_damaged_memory_is_an_error_that_says_what_to_do(text: str) -> None:
    stage = Stage()
    stage.flash.text = text
    with pytest.raises(MemoryUnusable, match="move the file away"):
        stage.restart()


def test_the_memory_of_another_robot_is_not_used() -> None:
    stage = Stage()
    stage.run_for(1)
    assert refusal(stage, script(packet("a1", "FLY")))
    assert stage.flash.text is not None
    stage.flash.text = stage.flash.text.replace('"robot":"carl"', '"robot":"ginger"', 1)
    with pytest.raises(MemoryUnusable, match="give each robot a file of its own"):
        stage.restart()


def test_progress_says_by_default_that_the_packet_runs() -> None:
    assert Progress().state is ProgressState.RUNNING
