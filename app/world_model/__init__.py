"""The world model (MACTA §4, fig. 4): what is believed of a world, how it changes, and the problem it poses.

Pure but for `store` and `desk`, which keep the facts in the record and are not handed on here.
"""

from app.world_model.beliefs import Change, Facts, occupants, place_of, revised, revision, spot_of
from app.world_model.initial import initial_facts, initial_spots
from app.world_model.problem import Reservation, objects_of, planning_problem, reservation_of
from app.world_model.progress import applied, broken, rests_on
from app.world_model.reconcile import reconciled

__all__ = [
    "Change",
    "Facts",
    "Reservation",
    "applied",
    "broken",
    "initial_facts",
    "initial_spots",
    "objects_of",
    "occupants",
    "place_of",
    "planning_problem",
    "reconciled",
    "reservation_of",
    "rests_on",
    "revised",
    "revision",
    "spot_of",
]
