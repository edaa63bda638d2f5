"""Fred and Ginger relocate the rock sample together (MACTA §1, §5), coupled only by what they sense."""

from collections.abc import Callable

import pytest

from benchmarks.relocation import THING, TO, relocate, scripts
from robots.executive.packet_run import UNSEEN_S
from robots.wire import PacketState, ScriptState
from robots.world import load_world
from sim.physics.beam import TRAVEL_M
from sim.trials.script_runner import ScriptRunner


def test_both_carry_the_sample_past_the_rocks_and_ginger_deposits_it_at_the_lander() -> None:
    ended = relocate(seed=0)
    assert ended.succeeded, ended.words
    assert ended.slipped == 0
    assert 0.005 < ended.deflection_m < TRAVEL_M
    done = {name: [each.tag for each in ended.ran if each.robot == name] for name in ("fred", "ginger")}
    assert done["fred"] == ["NAVIGATE", "DOCK", "TRANSPORT", "RELEASE1"]
    assert done["ginger"] == ["TRACK", "DOCK2", "TRANSPORT", "RELEASE2"]


@pytest.mark.parametrize("seed", [18, 38])
def test_who_has_gripped_first_does_not_set_off_before_the_other_has_gripped_too(seed: int) -> None:
    with ScriptRunner(load_world("relocation_lab"), seed=seed, jitter_m=0.0) as runner:
        runner.send(scripts())

        def one_sets_off() -> bool:
            runner.receive()
            running = [one.packet_id for one in runner.reports if one.state is PacketState.RUNNING]
            return "3_transport" in running

        assert runner.simulation.run_until(one_sets_off, timeout_s=60)
        assert set(runner.simulation.truth().samples[THING].holders) == {"fred", "ginger"}


def cut_short(mishap: Callable[[ScriptRunner], None], *, at_s: float = 35.0) -> ScriptRunner:
    """The relocation with something that happens while both transport; until both scripts have ended."""
    runner = ScriptRunner(load_world("relocation_lab"), seed=1)
    happened: list[float] = []

    def meanwhile() -> None:
        now_s = runner.simulation.clock.now_s()
        if now_s >= at_s and not happened:
            happened.append(now_s)
            mishap(runner)

    assert runner.run(scripts(), timeout_s=at_s + UNSEEN_S + 20, meanwhile=meanwhile), (
        "a robot waits in silence"
    )
    assert happened
    return runner


def failure(runner: ScriptRunner, robot: str) -> str:
    return next(
        report.detail
        for report in runner.reports
        if report.script_id == f"{robot}_relocates" and report.state == "failed"
    )


def test_who_is_let_down_by_its_partner_says_what_it_sees() -> None:
    runner = cut_short(lambda runner: runner.simulation.bodies["ginger"].set_gripper(closed=False))
    assert "TRANSPORT broke off: the robot holds nothing" in failure(runner, "ginger")
    assert f"from a handle of {THING}" in failure(runner, "fred")
    assert runner.simulation.truth().samples[THING].holders == ("fred",)


def test_who_is_held_back_by_a_partner_that_stands_gives_up_without_dropping_the_sample() -> None:
    runner = cut_short(lambda runner: runner.cancel(runner.scripts[1]))
    assert runner.ended["ginger_relocates"].state is ScriptState.CANCELLED
    assert f"made no progress after 0 retries: the robot has {THING}" in failure(runner, "fred")
    assert f"short of {TO}" in failure(runner, "fred")
    assert runner.simulation.truth().slipped == 0


def test_who_waits_in_vain_for_a_partner_says_so() -> None:
    runner = ScriptRunner(load_world("relocation_lab"), seed=1)
    alone = scripts()[0]
    hasty = alone.model_copy(
        update={"packets": tuple(one.model_copy(update={"wait_timeout_s": 10.0}) for one in alone.packets)}
    )
    assert runner.run([hasty], timeout_s=60)
    said = failure(runner, "fred")
    assert "TRANSPORT could not start within 10 s: the robot sees ginger" in said
    assert f"from a handle of {THING}" in said
