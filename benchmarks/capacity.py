"""Memory that waiting missions use: `python -m benchmarks.capacity [MISSIONS]`.

One plan is made; its goal, plan and mission are copied in the record MISSIONS times, although they share robots. The
robots never answer, so every mission's workflow waits. Prints the memory of the service's process before and after.
"""

import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from sqlalchemy import func, inspect, select

from app.composition import RunningWorld, Service, make_engine
from app.domain.lifecycles.mission import MissionState
from app.planning.goal_service import GoalRequest
from app.planning.pool.pool import PlanningWorker
from app.planning.pool.process_tree import Running, tree_of
from app.settings import Settings
from app.store import GoalRow, MissionRow, PlanRow, ScriptRow
from app.workflows import MISSION_LIFE, MISSIONS
from benchmarks.planned import planned
from robots.clock import ManualClock
from robots.link import InMemoryLink
from robots.world import load_world

SETTLE_S, GIVE_UP_S = 20.0, 900.0


def memory_mb(process: Running) -> float:
    """The process's memory, once newly started threads have settled."""
    time.sleep(SETTLE_S)
    return process.memory_mb


def copied(row: Any, **changes: Any) -> Any:
    """A copy of the row with these changes."""
    values = {column.key: getattr(row, column.key) for column in inspect(type(row)).column_attrs}
    return type(row)(**{**values, **changes})


def begin(service: Service, goal_id: str, missions: int) -> None:
    """Start missions, each with a goal and a plan of its own."""
    with service.database.write() as session:
        goal = session.get_one(GoalRow, goal_id)
        plan = session.get_one(PlanRow, goal.plan_id)
        for number in range(missions):
            name = f"mission-{number}"
            session.add(copied(goal, id=f"goal-{number}", state="committed", mission_id=name))
            session.flush()
            session.add(copied(plan, id=f"plan-{number}", goal_id=f"goal-{number}", state="approved"))
            session.flush()
            session.add(
                MissionRow(
                    id=name,
                    workflow=name,
                    goal_id=f"goal-{number}",
                    plan_id=f"plan-{number}",
                    world=plan.world,
                    state=MissionState.PENDING,
                    estimate_s=60.0,
                    original_estimate_s=60.0,
                    margin_s=1e6,
                )
            )
            service.core.workflows.start(session, MISSIONS, MISSION_LIFE, name, name)


def wait_for_scripts(service: Service, missions: int) -> None:
    """Wait until every mission is organised and waits for its robots."""
    give_up = time.monotonic() + GIVE_UP_S
    while True:
        with service.database.read() as session:
            if (session.scalar(select(func.count(ScriptRow.mission_id.distinct()))) or 0) >= missions:
                return
        if time.monotonic() > give_up:
            raise TimeoutError(f"{missions} missions were not organised within {GIVE_UP_S:.0f} s")
        time.sleep(0.5)


def main(missions: int = 1000) -> None:
    worker = PlanningWorker(make_engine)
    worker.warm_up().result()
    process = tree_of(os.getpid())[0]
    world = load_world("sample_store")
    running = RunningWorld(
        file=world, link=InMemoryLink.pair()[0], clock=ManualClock(), rate=1.0, run="benchmark"
    )
    # Some workflows may still be writing when the service has ended.
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        settings = Settings(data=Path(folder), token="a-token-of-the-benchmark", database_url=None)
        with Service(settings, [running], worker=worker) as service:
            goal, _ = planned(service, GoalRequest(world="sample_store", text="move sample_1 to bay_7"))
            before_mb = memory_mb(process)
            begun = time.monotonic()
            begin(service, goal.id, missions)
            wait_for_scripts(service, missions)
            took_s = time.monotonic() - begun
            after_mb = memory_mb(process)
            print(f"{missions} missions wait, organised within {took_s:.0f} s")
            print(
                f"{before_mb:.0f} MiB before, {after_mb:.0f} after: {after_mb - before_mb:.0f} MiB more",
                flush=True,
            )
    worker.close()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
