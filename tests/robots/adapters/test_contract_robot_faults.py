"""Whatever is lost, repeated or reordered, and wherever the power fails: nothing is done twice, nothing is lost."""

from random import Random

import pytest

from robots.wire import Control, ControlVerb, PacketState, Performative, ScriptState
from tests.robots.adapters.foreign_robot import ALL_DONE, Stage, fetch, packet, script

LOG = ["s1/a1", "s1/a2", "s1/a3"]
SECOND = script(packet("a1", "NAVIGATE", ref2="yard"), name="s2", mission="m2")


def carried_out(stage: Stage) -> None:
    """The script is ordered, cleared and followed to the end; then a second one."""
    order = fetch()
    request = stage.order(order)
    assert stage.run_until(lambda: any(one.in_reply_to == request.id for one in stage.service.heard))
    stage.clear(order, "a9")
    assert stage.run_until(lambda: bool(stage.service.ends))
    stage.order(SECOND)
    assert stage.run_until(lambda: len(stage.service.ends) >= 2)
    stage.run_for(60)


def assert_all_done_once(stage: Stage) -> None:
    assert stage.machine.log == [*LOG, "s2/a1"]
    assert stage.machine.done == stage.machine.log
    told = [one for one in stage.service.reports if one.script_id == "s1"]
    assert {(one.packet_id, one.state) for one in told} == set(ALL_DONE)
    finished = [one.packet_id for one in told if one.state is PacketState.FINISHED]
    assert sorted(finished) == ["a1", "a2", "a3"]
    assert sorted((end.script_id, end.state) for end in stage.service.ends) == [
        ("s1", ScriptState.FINISHED),
        ("s2", ScriptState.FINISHED),
    ]


def operations() -> int:
    """The operations of a run without faults."""
    stage = Stage()
    carried_out(stage)
    assert_all_done_once(stage)
    return stage.power.used


def test_the_power_may_fail_at_every_single_operation() -> None:
    total = operations()
    assert total > 100
    for number in range(1, total + 1):
        stage = Stage(fails_at=[number])
        carried_out(stage)
        assert stage.restarts == 1, number
        assert_all_done_once(stage)


@pytest.mark.parametrize("start", range(0, 200, 50))
def test_two_hundred_random_runs_over_a_lossy_link_with_restarts(start: int) -> None:
    for seed in range(start, start + 50):
        random = Random(seed)
        fails_at = random.sample(range(1, 400), k=random.randrange(8))
        stage = Stage(seed=seed, faults=random.choice((0.1, 0.3, 0.5)), fails_at=fails_at)
        carried_out(stage)
        assert_all_done_once(stage)


@pytest.mark.parametrize("seed", range(20))
def test_orders_hold_over_restarts(seed: int) -> None:
    """A cancel that was acknowledged is followed wherever the power fails after that."""
    random = Random(seed)
    stage = Stage(seed=seed, faults=0.2, fails_at=random.sample(range(1, 300), k=6))
    stage.machine.stops_in_s = random.choice((0.0, 2.0))
    order = fetch()
    stage.order(order)
    stage.run_for(random.uniform(0.5, 8.0))
    cancel = Control(script_id="s1", verb=ControlVerb.CANCEL)
    stage.service.send(cancel, Performative.CANCEL, repeat=True)
    assert stage.run_until(lambda: bool(stage.service.ends))
    stage.run_for(30)
    assert [end.state for end in stage.service.ends] == [ScriptState.CANCELLED]
    assert stage.machine.current is None
    assert "s1/a2" not in stage.machine.log
    assert len(stage.machine.log) == len(set(stage.machine.log))


def test_a_robot_that_is_to_stop_when_the_power_fails_is_stopped_before_it_is_reported_cancelled() -> None:
    stage = Stage()
    stage.machine.work_s = 1e9
    stage.machine.stops_in_s = 5.0
    stage.order(fetch())
    stage.run_for(2)
    stage.service.send(Control(script_id="s1", verb=ControlVerb.CANCEL), Performative.CANCEL)
    stage.step()
    stage.restart()
    assert stage.run_until(lambda: bool(stage.service.ends))
    assert stage.machine.current is None


def test_what_was_cancelled_in_advance_is_refused_after_a_restart() -> None:
    stage = Stage()
    stage.service.send(Control(script_id="s1", verb=ControlVerb.CANCEL), Performative.CANCEL)
    stage.run_for(1)
    stage.restart()
    request = stage.order(fetch())
    stage.run_for(1)
    assert "cancelled before it arrived" in stage.service.answer(request).reason


def test_a_paused_robot_is_paused_after_a_restart() -> None:
    stage = Stage()
    stage.order(fetch())
    stage.run_for(2)
    stage.service.send(Control(script_id="s1", verb=ControlVerb.PAUSE, number=1))
    stage.run_for(1)
    stage.restart()
    stage.machine.paused = False
    stage.run_for(10)
    assert stage.machine.paused
    assert stage.driver.calls == ["start", "pause"]
