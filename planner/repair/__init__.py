"""Repair of plan-nets after the world has changed, and insertion of new goals into running missions."""

from planner.repair.difference import Difference, compare
from planner.repair.goal_insertion import join
from planner.repair.plan_repair import Course, Repair, repair
from planner.repair.remaining import NOT_BEGUN, MissionProgress, Remaining

__all__ = [
    "NOT_BEGUN",
    "Course",
    "Difference",
    "MissionProgress",
    "Remaining",
    "Repair",
    "compare",
    "join",
    "repair",
]
