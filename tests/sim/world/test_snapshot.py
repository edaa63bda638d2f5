"""A world goes on from its snapshot: nothing jumps, nothing is released, no robot starts again."""

from math import hypot
from typing import Any

import pytest

from benchmarks.bodies import embodied
from benchmarks.relocation import THING, TO, scripts
from robots.physical.body import Pose
from robots.wire import PacketState, ScriptState
from robots.world import WorldFile, digest_of, load_world
from sim.snapshot import WorldSnapshot
from sim.trials.script_runner import ScriptRunner
from sim.truth import Truth
from sim.world.agent import AgentSetup
from sim.world.agents import behavioural_agent
from sim.world.simulation import Simulation
from tests.sim.rig import run_s, two_rooms

STILL_M = 1e-9


class Wanderer:
    """Drives ahead, turns where whiskers are short, and snaps at what comes between its jaws."""

    def __init__(self, setup: AgentSetup) -> None:
        self._body = setup.body

    def tick(self) -> None:
        readings = self._body.sense()
        ranges_m = readings.ranges_m
        assert ranges_m is not None
        assert readings.gripper is not None
        ahead_m = min(ranges_m[[0, 1, -1]])
        self._body.set_velocity(*((0.5, 0.0) if ahead_m > 0.4 else (0.0, 1.2)))
        if readings.gripper.between_jaws is not None:
            self._body.set_gripper(closed=True)


def wandering(world: WorldFile, snapshot: WorldSnapshot | None = None) -> Simulation:
    return Simulation(world, make_agent=Wanderer, seed=3, snapshot=snapshot)


def taken(simulation: Simulation) -> WorldSnapshot:
    """Its snapshot, as it comes back from the disk."""
    snapshot = simulation.snapshot()
    read = WorldSnapshot.model_validate_json(snapshot.model_dump_json())
    assert read == snapshot
    return read


def off_m(one: Truth, other: Truth) -> float:
    """The farthest that anything is off, a turn counted as metres."""
    poses = zip(one.robots.values(), other.robots.values(), strict=True)
    rovers = [_apart(a, b) + abs(a.heading_rad - b.heading_rad) for a, b in poses]
    samples = zip(one.samples.values(), other.samples.values(), strict=True)
    return max(*rovers, *(_apart(a, b) + abs(a.heading_rad - b.heading_rad) for a, b in samples))


def _apart(one: Any, other: Any) -> float:
    return hypot(one.x_m - other.x_m, one.y_m - other.y_m)


@pytest.mark.parametrize("kind", ["velocity", "wheeled", "avatar"])
def test_nothing_moves_at_a_resumption_and_rovers_keep_their_pace(kind: str) -> None:
    world = embodied(load_world("sample_store"), {"kind": kind})
    simulation = wandering(world)
    run_s(simulation, 12)
    resumed = wandering(world, taken(simulation))
    assert off_m(simulation.truth(), resumed.truth()) < STILL_M
    assert resumed.clock.now_s() == simulation.clock.now_s()
    before = simulation.truth().robots
    run_s(simulation, 0.05)
    run_s(resumed, 0.05)
    for name, was in before.items():
        one, other = simulation.truth().robots[name], resumed.truth().robots[name]
        assert _apart(one, other) < 0.002
        assert _apart(was, other) > 0.5 * _apart(was, one)


@pytest.mark.parametrize("kind", ["velocity", "wheeled", "avatar"])
def test_two_resumptions_of_one_snapshot_are_the_same_to_the_last_bit(kind: str) -> None:
    world = embodied(load_world("sample_store"), {"kind": kind})
    simulation = wandering(world)
    run_s(simulation, 7)
    snapshot, told = taken(simulation), []
    for _ in range(2):
        resumed = wandering(world, snapshot)
        run_s(resumed, 6)
        bodies = resumed.bodies.values()
        told.append(repr((resumed.truth(), [(body.sense(), body.get_position()) for body in bodies])))
    assert told[0] == told[1]


def test_a_run_has_a_name_of_its_own_and_keeps_it() -> None:
    world = two_rooms()
    one, other = wandering(world), wandering(world)
    assert one.run != other.run
    assert wandering(world, taken(one)).run == one.run


def test_the_digest_tells_worlds_apart_but_not_how_a_file_is_written() -> None:
    world = load_world("sample_store")
    assert digest_of(world) == digest_of(WorldFile.model_validate(world.model_dump()))
    assert digest_of(world) != digest_of(embodied(world, {"kind": "wheeled"}))


def test_a_body_of_another_kind_begins_at_rest_where_the_former_one_reckoned_to_be() -> None:
    world = two_rooms()
    before = wandering(world)
    snapshot = taken(before)
    body = wandering(embodied(world, {"kind": "wheeled"}), snapshot).bodies["fred"]
    assert body.get_position() == before.bodies["fred"].get_position()
    assert body.driven == (0.0, 0.0)
    assert body.battery.left_j == before.bodies["fred"].battery.left_j


def test_a_held_sample_is_still_held_and_out_of_the_way() -> None:
    world = two_rooms((1, 1, 0), samples={"rock": "corner"})
    simulation = Simulation(world, make_agent=Wanderer, jitter_m=0.0)
    simulation.scene.put_rover("fred", Pose(x_m=0.8, y_m=1.5, heading_rad=3.14159))
    assert simulation.run_until(lambda: simulation.truth().samples["rock"].holders == ("fred",), timeout_s=9)
    resumed = Simulation(world, make_agent=Wanderer, snapshot=taken(simulation))
    assert resumed.truth().samples["rock"].holders == ("fred",)
    assert resumed.scene.sample_point("rock") == pytest.approx(
        simulation.scene.sample_point("rock"), abs=STILL_M
    )
    run_s(resumed, 3)
    resumed.bodies["fred"].set_gripper(closed=False)
    assert resumed.truth().samples["rock"].holders == ()


def begun(runner: ScriptRunner) -> list[tuple[str, str]]:
    return [
        (r.script_id, r.packet_id) for r in runner.reports if r.state is PacketState.RUNNING and not r.detail
    ]


def work(runner: ScriptRunner, *, restarts_s: list[float], until_s: float) -> None:
    """Let the runner work on, the world restarted at these instants, until all scripts have ended."""
    while len(runner.ended) < len(runner.scripts) and runner.simulation.clock.now_s() < until_s:
        runner.receive()
        for _ in range(3):
            runner.simulation.step()
        if restarts_s and runner.simulation.clock.now_s() >= restarts_s[0]:
            restarts_s.pop(0)
            before, held = runner.simulation.truth(), runner.simulation
            runner.restart()
            assert off_m(before, runner.simulation.truth()) < STILL_M
            assert before.deflections_m == pytest.approx(runner.simulation.truth().deflections_m, abs=STILL_M)
            assert held is not runner.simulation


def test_two_rovers_carry_a_long_sample_on_through_restarts() -> None:
    with ScriptRunner(load_world("relocation_lab"), seed=1) as runner:
        runner.send(scripts())
        work(runner, restarts_s=[6.0, 25.0, 35.0, 36.0, 44.0], until_s=200.0)
        truth = runner.simulation.truth()
    assert [end.state for end in runner.ended.values()] == [ScriptState.FINISHED] * 2, runner.ended
    assert truth.samples[THING].ref == TO
    assert truth.slipped == 0
    packets = [(each.id, packet.id) for each in scripts() for packet in each.packets]
    assert sorted(begun(runner)) == sorted(packets)


def test_a_robots_memory_is_part_of_the_worlds() -> None:
    simulation = Simulation(load_world("sample_store"), make_agent=behavioural_agent, seed=3)
    run_s(simulation, 1)
    snapshot = taken(simulation)
    assert set(snapshot.robots) == set(simulation.agents)
    resumed = Simulation(load_world("sample_store"), make_agent=behavioural_agent, snapshot=snapshot)
    assert resumed.snapshot().robots == snapshot.robots
