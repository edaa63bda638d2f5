"""The queues that workflows wait in."""

from dataclasses import dataclass

from app.domain.heartbeats import PLANNING_QUEUE


@dataclass(frozen=True, slots=True, kw_only=True)
class Queue:
    """A queue of workflows.

    :param at_once: how many of them run in one process.
    :param waits: whether so few run at once that others wait for their ends.
    """

    name: str
    at_once: int
    waits: bool = True


PLANNING = Queue(name=PLANNING_QUEUE, at_once=4)
LARGE_PLANNING = Queue(name="planning-large", at_once=2)
WAITING = Queue(name="waiting", at_once=1)
MISSIONS = Queue(name="missions", at_once=1000, waits=False)
BETTER_PLANS = Queue(name="better-plans", at_once=1)
"""Apart from the queues of goals, which never wait for it."""
QUEUES = (PLANNING, LARGE_PLANNING, WAITING, MISSIONS, BETTER_PLANS)

PLAN_GOAL = "plan_goal"
"""Workflow: plan one goal."""
PLAN_WAITING = "plan_waiting"
"""Workflow: plan the waiting goals of one world, the most urgent first."""
FIND_ALTERNATIVES = "find_alternatives"
"""Workflow: search for alternatives to a goal's proposed plan."""
MISSION_LIFE = "mission_life"
"""Workflow: organise, dispatch and monitor one mission."""
RECOVER_MISSION = "recover_mission"
"""Workflow: plan the repair of one mission."""
SEEK_BETTER_PLANS = "seek_better_plans"
"""Workflow: look for better plans of the missions under way in one world."""
