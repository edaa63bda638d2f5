"""The world model (MACTA §4, fig. 4): facts believed of a world, their revision, and the planning problem. Pure."""

from app.domain.world_model.beliefs import (
    Change,
    Facts,
    belief_change,
    occupants,
    place_of,
    revise_beliefs,
    spot_of,
)
from app.domain.world_model.initial import initial_facts, initial_spots
from app.domain.world_model.plan_effects import apply_action, broken_support, initial_support
from app.domain.world_model.problem import objects_of, planning_problem
from app.domain.world_model.reconcile import reconcile_report, told_by_events
from app.domain.world_model.reservation import Reservation, filled_by, named_in, needed_by, taken_by, union_of

__all__ = [
    "Change",
    "Facts",
    "Reservation",
    "apply_action",
    "belief_change",
    "broken_support",
    "filled_by",
    "initial_facts",
    "initial_spots",
    "initial_support",
    "named_in",
    "needed_by",
    "objects_of",
    "occupants",
    "place_of",
    "planning_problem",
    "reconcile_report",
    "revise_beliefs",
    "spot_of",
    "taken_by",
    "told_by_events",
    "union_of",
]
