"""Repair of plan-nets after the world has changed or people have pinned something, and insertion of new goals into
running missions."""

from planner.plan_nets.difference import Difference, compare
from planner.repair.goal_insertion import join
from planner.repair.pins import (
    CannotPin,
    Pin,
    PlanHandles,
    edit,
    pinned,
    unkept_pins,
    without_hopeless_pins,
)
from planner.repair.plan_repair import KEPT_ON_REQUEST_S, Course, Repair, repair
from planner.repair.remaining import NOT_BEGUN, MissionProgress, Remaining

__all__ = [
    "KEPT_ON_REQUEST_S",
    "NOT_BEGUN",
    "CannotPin",
    "Course",
    "Difference",
    "MissionProgress",
    "Pin",
    "PlanHandles",
    "Remaining",
    "Repair",
    "compare",
    "edit",
    "join",
    "pinned",
    "repair",
    "unkept_pins",
    "without_hopeless_pins",
]
