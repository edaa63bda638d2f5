"""The world model (MACTA §4, fig. 4): what is believed of a world, how it changes, and the problem it poses.

Pure but for `store` and `desk`, which keep the facts in the record and are not handed on here.
"""

from app.domain.world_model.beliefs import Change, Facts, occupants, place_of, revised, revision, spot_of
from app.domain.world_model.initial import initial_facts, initial_spots
from app.domain.world_model.plan_effects import applied, broken, rests_on
from app.domain.world_model.problem import objects_of, planning_problem
from app.domain.world_model.reconcile import reconciled
from app.domain.world_model.reservation import Reservation, all_of, named_in, needed_by, taken_by

__all__ = [
    "Change",
    "Facts",
    "Reservation",
    "all_of",
    "applied",
    "broken",
    "initial_facts",
    "initial_spots",
    "named_in",
    "needed_by",
    "objects_of",
    "occupants",
    "place_of",
    "planning_problem",
    "reconciled",
    "rests_on",
    "revised",
    "revision",
    "spot_of",
    "taken_by",
]
