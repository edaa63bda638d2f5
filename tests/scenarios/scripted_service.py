"""A service that has one plan, as a process of its own that is there to be killed: `python -m …scripted_service DATA`.

World, robots, agent models, workflows and record are as `macta serve` has them; there is no planner, no HTTP, no view.
States its one goal under an idempotency key, prints a JSON line of world's time and goal's outcome ten times a second,
and ends when the goal has.
"""

import gc
import json
import sys
import time
from pathlib import Path

gc.disable()  # until it has started, as in `macta serve`

# ruff: noqa: E402
from app.composition import RunningWorld, Service
from app.domain.lifecycles.goal import GoalState
from app.planning.goal_service import GoalRequest
from app.settings import Settings
from app.store.recorded_run import recorded_run
from sim import SnapshotSettings, SupervisedWorld
from tests.app.sample_store import Store
from tests.app.scripted import ScriptedWorker

GOAL = "move sample_1 to bay_7"
SPEED = 15.0


def main(data: Path) -> None:
    store = Store()
    data.mkdir(mode=0o700, exist_ok=True)  # as the command does when it reads its settings
    settings = Settings(data=data, token="a-token-for-the-storm", database_url=None)
    run = recorded_run(settings.resolved_database_url(), store.world.name)
    snapshots = SnapshotSettings(folder=data / "worlds", run=run)
    with SupervisedWorld.start(store.world, snapshots, seed=1, speed=SPEED, jitter_m=0.0) as simulation:
        simulation.pause()
        world = RunningWorld(
            file=store.world,
            link=simulation,
            clock=simulation,
            rate=SPEED,
            run=simulation.run,
            resume=lambda: simulation.pause(False),
        )
        with Service(settings, [world], worker=ScriptedWorker(store.store_sample_1())) as service:
            request = GoalRequest(world=store.world.name, text=GOAL, auto_approve=True)
            gc.freeze()
            gc.enable()
            goal = service.goals.submit(request, actor="storm", key="the goal")
            while True:
                goal = service.goals.get(goal.id)
                said = {"time_s": simulation.now_s(), "world": simulation.pid, "goal": goal.id}
                print(json.dumps({**said, "outcome": goal.outcome, "reason": goal.reason}), flush=True)
                if goal.state == GoalState.FINISHED:
                    return
                time.sleep(0.1)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
