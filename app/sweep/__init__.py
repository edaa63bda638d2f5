"""Missions over many seeds: goals drawn by chance, made into scripts without a service, and what became of them.

Pure: the simulated world in which they are carried out is the command line's.
"""

from app.sweep.chance import drawn_goals
from app.sweep.mission import Mission, NoMission, prepare, written
from app.sweep.row import Outcome, Row
from app.sweep.tally import Group, Spread, Tally, wilson

__all__ = [
    "Group",
    "Mission",
    "NoMission",
    "Outcome",
    "Row",
    "Spread",
    "Tally",
    "drawn_goals",
    "prepare",
    "wilson",
    "written",
]
