"""A world is kept on the disk: nothing leaves before it is there, and what cannot be gone on with is said plainly."""

import json
import os
import re
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from benchmarks.errands import Leg, script
from robots.clock import ManualClock
from robots.link import InMemoryLink, LinkClosed
from robots.wire import Acknowledgement, Message, Performative, ScriptRequest, Telemetry
from robots.world import WorldFile, load_world
from sim import SimulationError, SnapshotSettings, SupervisedWorld
from sim.error import NotResumable
from sim.process.persistence import MAX_INTERVAL_S, OutputCommit, StartedWorld, resume_or_start
from sim.process.process import SimulationProcess
from sim.process.snapshot_file import LOCK_TIMEOUT_S, SnapshotFile
from sim.snapshot import WorldSnapshot
from sim.world.agents import behavioural_agent
from sim.world.hub import Hub
from sim.world.simulation import Simulation
from tests.sim.rig import run_s, two_rooms
from tests.waiting import until

WORLD = two_rooms()


def hub(world: WorldFile = WORLD) -> Hub:
    return Hub(InMemoryLink.pair()[1], [spec.name for spec in world.robots])


def started(folder: Path, *, world: WorldFile = WORLD, **settings: object) -> StartedWorld:
    snapshots = SnapshotSettings(folder=folder, **settings)  # type: ignore[arg-type]
    with SnapshotFile(snapshots.path_of(world)) as file:
        return resume_or_start(
            world, snapshots, file, hub(world), make_agent=behavioural_agent, seed=1, jitter_m=0.4
        )


def kept(folder: Path, *, after_s: float = 0.5) -> Simulation:
    """A world that ran for a while and is kept."""
    simulation = started(folder).simulation
    run_s(simulation, after_s)
    with SnapshotFile(folder / "two_rooms.json") as file:
        file.write(simulation.snapshot())
    return simulation


def test_the_last_shown_time_of_a_world_that_will_be_resumed_is_known_before(tmp_path: Path) -> None:
    settings = SnapshotSettings(folder=tmp_path, run="run-1")
    assert settings.shown_s(WORLD) == 0.0
    with SnapshotFile(settings.path_of(WORLD)) as file:
        file.write_clock(12.5)
    assert settings.shown_s(WORLD) == 12.5
    assert SnapshotSettings(folder=tmp_path).shown_s(WORLD) == 0.0
    assert SnapshotSettings(folder=tmp_path, run="run-1", start_new=True).shown_s(WORLD) == 0.0
    settings.path_of(WORLD).with_suffix(".clock").write_bytes(b"torn")
    assert settings.shown_s(WORLD) == 0.0


def test_the_first_world_of_a_folder_begins_without_a_message(tmp_path: Path) -> None:
    first = started(tmp_path)
    assert (first.is_resumed, first.not_resumed_because) == (False, "")


def test_a_kept_world_goes_on_where_it_stood(tmp_path: Path) -> None:
    before = kept(tmp_path)
    after = started(tmp_path, run=before.run)
    assert (after.is_resumed, after.not_resumed_because) == (True, "")
    assert after.simulation.run == before.run
    assert after.simulation.truth().robots == before.truth().robots
    assert after.simulation.clock.ticks == before.clock.ticks
    assert (tmp_path / "two_rooms.json").stat().st_mode & 0o777 == 0o600


def test_who_keeps_no_record_goes_on_with_whatever_run_is_there(tmp_path: Path) -> None:
    before = kept(tmp_path)
    assert started(tmp_path, any_run=True).simulation.run == before.run


def test_the_clock_goes_on_from_where_it_was_last_shown(tmp_path: Path) -> None:
    before = kept(tmp_path)
    with SnapshotFile(tmp_path / "two_rooms.json") as file:
        file.write_clock(before.clock.now_s() + 0.75)
    after = started(tmp_path, run=before.run).simulation
    assert after.clock.now_s() == pytest.approx(before.clock.now_s() + 0.75, abs=1 / 120)
    assert after.truth().robots == before.truth().robots


def other_world(folder: Path) -> StartedWorld:
    run = kept(folder).run
    return started(folder, run=run, world=two_rooms((0.7, 1, 0)))


def torn(folder: Path) -> StartedWorld:
    run, path = kept(folder).run, folder / "two_rooms.json"
    path.write_bytes(path.read_bytes()[:-200])
    return started(folder, run=run)


def other_format(folder: Path) -> StartedWorld:
    run, path = kept(folder).run, folder / "two_rooms.json"
    path.write_text(json.dumps({"format": 0, "run": run}))
    return started(folder, run=run)


def other_software(folder: Path) -> StartedWorld:
    run, path = kept(folder).run, folder / "two_rooms.json"
    data = json.loads(path.read_text())
    del data["bodies"]["fred"]
    path.write_text(json.dumps(data, separators=(",", ":")))
    return started(folder, run=run)


@pytest.mark.parametrize(
    ("case", "why"),
    [
        (other_world, "its snapshot is of another world file"),
        (torn, "its snapshot cannot be read: .*EOF"),
        (other_format, "its snapshot is not of format 1"),
        (other_software, "its snapshot does not fit: KeyError: 'fred'"),
        (lambda f: started(f, run=kept(f).run, start_new=True), "an operator wished it so"),
        (lambda f: started(f, run="another" + kept(f).run), "of a run that the record does not tell of"),
        (lambda f: started(f, run="gone"), "there is no snapshot of it"),
    ],
)
def test_what_cannot_be_gone_on_with_starts_a_new_run_and_says_why(
    tmp_path: Path, case: Callable[[Path], StartedWorld], why: str
) -> None:
    found = case(tmp_path)
    assert re.search(why, found.not_resumed_because)
    assert found.simulation.clock.ticks == 0


def test_a_world_that_must_go_on_does_not_start_a_new_run(tmp_path: Path) -> None:
    with pytest.raises(NotResumable, match="there is no snapshot"):
        started(tmp_path, run="gone", resume_only=True)


class SteppedClock(ManualClock):
    """Sleeping advances it."""

    def sleep(self, seconds: float) -> None:
        self.advance(seconds)


def test_two_processes_cannot_store_their_world_in_one_place(tmp_path: Path) -> None:
    clock = SteppedClock()
    with SnapshotFile(tmp_path / "w.json"), pytest.raises(SimulationError, match="another process keeps"):
        SnapshotFile(tmp_path / "w.json", clock)
    assert clock.now_s() == pytest.approx(LOCK_TIMEOUT_S, abs=0.1)
    SnapshotFile(tmp_path / "w.json").close()


class Kept:
    """A sample store that is kept, with the service's end of its link and a wall clock set by hand."""

    def __init__(self, folder: Path) -> None:
        world = load_world("sample_store")
        self.clock = ManualClock()
        self.service, robots_end = InMemoryLink.pair()
        self.file = SnapshotFile(folder / "store.json")
        self.simulation = Simulation(
            world,
            make_agent=behavioural_agent,
            seed=2,
            jitter_m=0.0,
            hub=Hub(robots_end, [spec.name for spec in world.robots], holds=True),
        )
        self.commit = OutputCommit(self.simulation, self.file, self.clock)
        self.path = folder / "store.json"

    def order(self) -> None:
        leg = Leg(robot="yard_1", fetch="door_1", deposit="interchange_1")
        order = ScriptRequest(script=script(leg, "sample_1", handed_over=False))
        self.service.send(
            Message(
                performative=Performative.REQUEST,
                sender="service",
                receiver="yard_1",
                sent_at_s=0,
                body=order,
            )
        )

    def said(self) -> list[Message]:
        """What has left, but telemetry."""
        return [message for message in self.service.receive() if not isinstance(message.body, Telemetry)]

    def remembered(self) -> set[str]:
        """The ids of all that robots are known to have said, by the snapshot on the disk."""
        boxes = [
            robot.mind.mailbox
            for robot in WorldSnapshot.model_validate_json(self.path.read_bytes()).robots.values()
        ]
        answers = {answer.id for box in boxes for answer in box.answers}
        return answers | {report.id for box in boxes for report in box.reports}


def test_nothing_leaves_before_the_snapshot_that_contains_it(tmp_path: Path) -> None:
    world = Kept(tmp_path)
    world.commit.take()
    world.order()
    left = []
    for _ in range(600):
        world.simulation.step()
        world.clock.advance(1 / 60)
        before = world.said()
        assert {message.id for message in before} <= world.remembered()
        world.commit.take_if_due()
        left += [*before, *world.said()]
    assert len({message.id for message in left}) >= 4


def test_what_is_said_waits_while_the_disk_refuses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    world = Kept(tmp_path)

    def full(snapshot: WorldSnapshot) -> None:
        raise OSError(28, "No space left on device")

    world.commit.take()
    monkeypatch.setattr(world.file, "write", full)
    world.order()
    for _ in range(90):
        world.simulation.step()
        world.clock.advance(1 / 60)
        world.commit.take_if_due()
    assert world.said() == []
    assert caplog.text.count("No space left on device; its robots' messages wait") == 1
    monkeypatch.undo()
    world.clock.advance(MAX_INTERVAL_S)
    world.commit.take_if_due()
    assert world.said()


def test_snapshots_take_no_more_than_their_share_of_the_time(tmp_path: Path) -> None:
    world = Kept(tmp_path)
    taken = []

    def slow(snapshot: WorldSnapshot) -> None:
        taken.append(world.clock.now_s())
        world.clock.advance(0.05)

    world.file.write = slow  # type: ignore[method-assign]
    while world.clock.now_s() < 10:
        world.simulation.hub.link_of("yard_1").send(
            Message(
                performative=Performative.INFORM,
                sender="yard_1",
                receiver="service",
                sent_at_s=0,
                body=Acknowledgement(script_id="s"),
            )
        )
        world.commit.take_if_due()
        world.clock.advance(0.01)
    assert 0.4 < 10 / 0.5 / len(taken) < 1.1


def test_messages_do_not_wait_long_after_one_snapshot_that_took_long(tmp_path: Path) -> None:
    world = Kept(tmp_path)
    lasts_s = iter([0.02, 0.3, 0.02])
    world.file.write = lambda snapshot: world.clock.advance(next(lasts_s))  # type: ignore[method-assign]
    world.commit.take()
    world.commit.take()
    ended_s = world.clock.now_s()
    world.simulation.hub.link_of("yard_1").send(
        Message(
            performative=Performative.INFORM,
            sender="yard_1",
            receiver="service",
            sent_at_s=0,
            body=Acknowledgement(script_id="s"),
        )
    )
    while not world.said():
        world.clock.advance(0.01)
        world.commit.take_if_due()
    assert world.clock.now_s() - ended_s < 0.25


def test_a_world_whose_process_is_killed_goes_on_from_its_snapshot(tmp_path: Path) -> None:
    def start(settings: SnapshotSettings) -> SimulationProcess:
        return SimulationProcess.start(WORLD, seed=1, speed=20.0, snapshots=settings)

    with SupervisedWorld(start, SnapshotSettings(folder=tmp_path)) as world:
        until(lambda: world.now_s() > 5)
        pid, run = world.pid, world.run
        assert pid is not None
        os.kill(pid, signal.SIGKILL)
        died_at_s, seen_s = world.now_s(), []
        with pytest.raises(SimulationError, match="gone"):
            world.truth()
        heard: list[Message] = []
        while not heard:
            arrived = world.receive(0.05)
            heard += arrived if world.pid != pid else []
            seen_s.append(world.now_s())
        assert seen_s == sorted(seen_s)
        assert seen_s[0] >= died_at_s
        assert heard[0].sent_at_s >= died_at_s
    with pytest.raises(LinkClosed):
        world.receive()
    with SupervisedWorld(start, SnapshotSettings(folder=tmp_path, run=run)) as again:
        assert (again.run, again.not_resumed_because) == (run, "")
        assert again.now_s() >= seen_s[-1]


def test_a_world_that_dies_again_and_again_is_given_up(tmp_path: Path) -> None:
    class Dying:
        run = "r"
        robots = ()
        is_resumed = False
        not_resumed_because = ""
        pid = 1

        def __init__(self) -> None:
            self.link = self

        def receive(self, timeout_s: float) -> None:
            raise LinkClosed("gone")

        def stop(self) -> None: ...

        def pause(self, paused: bool) -> None: ...

    orders: list[SnapshotSettings] = []

    def start(settings: SnapshotSettings) -> Dying:
        orders.append(settings)
        return Dying()

    world = SupervisedWorld(start, SnapshotSettings(folder=tmp_path), wall_clock=ManualClock())  # type: ignore[arg-type]
    for _ in range(5):
        assert world.receive() == ()
    with pytest.raises(LinkClosed, match="crashed 6 times"):
        world.receive()
    assert [(order.run, order.resume_only) for order in orders] == [(None, False)] + [("r", True)] * 5


def test_a_new_process_that_cannot_be_commanded_is_ended() -> None:
    class Deaf:
        run = "r"
        robots = ()
        is_resumed = False
        not_resumed_because = ""
        pid = 1
        is_stopped = False

        def __init__(self) -> None:
            self.link = self

        def receive(self, timeout_s: float) -> None:
            raise LinkClosed("gone")

        def stop(self) -> None:
            self.is_stopped = True

        def pause(self, paused: bool) -> None:
            raise SimulationError("it does not answer")

    started: list[Deaf] = []

    def start(settings: SnapshotSettings) -> Deaf:
        started.append(Deaf())
        return started[-1]

    world = SupervisedWorld(start, SnapshotSettings(folder=Path("unused")), wall_clock=ManualClock())  # type: ignore[arg-type]
    with pytest.raises(LinkClosed, match="does not answer"):
        world.receive()
    assert [process.is_stopped for process in started] == [True, True]
