"""States a goal to a service and waits for its plan."""

import time

from app.composition import Service
from app.planning.goal_service import GoalRequest
from app.store import GoalRow

LOOK_S = 0.05


def planned(service: Service, request: GoalRequest) -> tuple[GoalRow, str]:
    """State a goal and wait for a plan of it; the goal and the plan's id.

    :raises RuntimeError: if there is none.
    """
    goal = service.goals.submit(request, actor="benchmark")
    while (goal := service.goals.get(goal.id)).state in ("submitted", "waiting", "planning"):
        time.sleep(LOOK_S)
    if goal.plan_id is None:
        raise RuntimeError(f"{goal.text}: {goal.state}, {goal.reason}")
    return goal, goal.plan_id
