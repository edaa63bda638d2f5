"""A repair under way: operators see its progress, as they do of a goal's first plan, and what it waits for."""

from collections.abc import Callable
from pathlib import Path

from sqlalchemy import select

from app.domain.blockers import Blockers
from app.domain.lifecycles.recovery import RecoveryStep
from app.planning.pool.process import Watch
from app.planning.pool.waiting_line import Job
from app.planning.pool.work import Answer, Solutions, Work, WorkResult
from app.store import EventRow, GoalRow
from app.store.migrate import migrate
from planner import PlanningStatus, Progress
from robots.wire import (
    Acknowledgement,
    Body,
    FailureCategory,
    Message,
    PacketReport,
    PacketState,
    Performative,
    ScriptReport,
    ScriptState,
)
from tests.app.missions.mission_services import WORLD, MissionServices, at_home, services
from tests.app.sample_store import Store
from tests.app.scripted import ScriptedWorker
from tests.app.stepped_clock import SteppedClock


class WatchedWorker(ScriptedWorker):
    """Takes two seconds, and tells after each how far it is."""

    def __init__(self, store: Store, clock: SteppedClock) -> None:
        super().__init__(store.store_sample_1())
        self._clock = clock

    def do(
        self,
        work: Work[Answer],
        time_limit_s: float,
        watch: Watch | None = None,
        job: Job | None = None,
        *,
        renew: Callable[[], Work[Answer]] | None = None,
        conclude: Callable[[WorkResult[Answer]], None] = lambda _: None,
    ) -> WorkResult[Answer]:
        assert watch is not None
        for second in (1.0, 2.0):
            self._clock.advance(1.0)
            watch.progress(
                Progress(engine="watched", elapsed_s=second, makespan_s=60.0, lower_bound_s=10.0 * second)
            )
        return super().do(work, time_limit_s, watch, conclude=conclude)


def fail(made: MissionServices, mission_id: str) -> None:
    """Have the mission's yard robot fail at its first packet, and the other one be stopped."""

    def say(robot: str, body: Body, in_reply_to: str | None = None) -> None:
        message = Message(
            performative=Performative.INFORM,
            sender=robot,
            receiver="service",
            sent_at_s=5.0,
            in_reply_to=in_reply_to,
            body=body,
        )
        assert made.record(message)

    scripts = {script.robot: script for script in made.scripts(mission_id)}
    for robot, script in scripts.items():
        say(robot, Acknowledgement(script_id=script.id), f"{script.id}:request")
    packet = scripts["yard_1"].body["packets"][0]["id"]
    failed = scripts["yard_1"].id
    say("yard_1", PacketReport(script_id=failed, packet_id=packet, state=PacketState.FAILED, at_s=5.0))
    ended = ScriptReport(
        script_id=failed,
        state=ScriptState.FAILED,
        at_s=5.0,
        category=FailureCategory.ROBOT,
        perceived=at_home("yard_1"),
    )
    say("yard_1", ended)
    made.life.monitor(mission_id)
    stopped = scripts["store_2"].id
    say(
        "store_2",
        ScriptReport(script_id=stopped, state=ScriptState.CANCELLED, at_s=6.0, perceived=at_home("store_2")),
    )
    made.life.monitor(mission_id)


def test_a_repair_tells_its_progress_while_it_is_planned(tmp_path: Path) -> None:
    store = Store()
    clock = SteppedClock()
    made = services(tmp_path, store=store, wall_clock=clock, worker=WatchedWorker(store, clock))
    migrate(made.database)
    made.start_world()
    _, mission_id = made.plans.approve(made.plan(recovery="auto"), actor="operator")
    made.life.monitor(mission_id)
    fail(made, mission_id)
    assert made.mission(mission_id).recovery_step == RecoveryStep.PLANNING
    made.recovery.plan_once(mission_id)
    assert made.mission(mission_id).revision == 2, made.mission(mission_id).attempts
    progress = select(EventRow).where(EventRow.type == "goal.progress").order_by(EventRow.seq)
    told = made.read(lambda session: session.scalars(progress).all())
    assert [(event.subject, event.data["engine"]) for event in told] == [("goal-1", "watched")] * 2
    assert [event.data["lower_bound_s"] for event in told] == [10.0, 20.0]
    assert all(event.data["makespan_s"] == 60.0 for event in told)
    assert made.read(lambda session: session.get_one(GoalRow, "goal-1")).planning is None
    made.close()


def test_why_a_repair_waits_follows_the_battery_of_the_robot_that_it_waits_for(tmp_path: Path) -> None:
    made = services(tmp_path, store=Store())
    migrate(made.database)
    made.start_world()
    _, mission_id = made.plans.approve(made.plan(recovery="auto"), actor="operator")
    made.life.monitor(mission_id)
    fail(made, mission_id)
    low = Blockers(missions=("mission m-2",), robots={"yard_2": "which charges, its battery at 10%"})
    with made.database.write() as session:
        mission = made.recovery.load(session, mission_id, lock=True)
        task = made.recovery.begin(session, mission)
        assert task is not None
        waiting: WorkResult[Solutions] = WorkResult(status=PlanningStatus.UNSOLVABLE, waits_for=low)
        made.recovery.conclude(session, mission, task, waiting)
    made.life.monitor(mission_id)
    assert made.mission(mission_id).reason.endswith(
        "waits for mission m-2 and yard_2, which charges, its battery at 10%"
    )
    made.waiting.unavailability_changed(WORLD, "yard_2", "which charges, its battery at 30%")
    made.waiting.unavailability_changed("another world", "yard_2", "which rests")
    made.waiting.handle_availability(WORLD)
    made.life.monitor(mission_id)
    assert made.mission(mission_id).reason.endswith(
        "waits for mission m-2 and yard_2, which charges, its battery at 30%"
    )
    made.close()
