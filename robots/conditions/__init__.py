"""Sensor conditions: what initiates, sustains and ends a behaviour packet (MACTA §3).

Each is a question to the percepts and answers with a verdict that says in words what was perceived. All are named and
composable, so that data can state them.
"""

from robots.conditions.beliefs import Believed, Close, Moving, NarrowPassage
from robots.conditions.composition import AllOf, AnyCondition, AnyOf, Not, in_words, unmet
from robots.conditions.long_objects import AtHandle, HoldsAlone, JointNear, LinedUp, Over, Still
from robots.conditions.motion import Advanced, AtRest, Elapsed, Faster, Heading, Raised, Travelled, Turned
from robots.conditions.own_state import (
    BetweenJaws,
    Bumped,
    Charged,
    Charging,
    Commanded,
    Empty,
    Holding,
    NotDriven,
)
from robots.conditions.position import (
    Abeam,
    Closer,
    Cramped,
    Facing,
    JawsAt,
    Near,
    OffPoint,
    OnCourse,
    Opening,
    Reached,
)
from robots.conditions.sight import Beside, Clear, InView, LiesAt, SoleHolder, Vacant
from robots.conditions.verdict import Condition, Verdict

__all__ = [
    "Abeam",
    "Advanced",
    "AllOf",
    "AnyCondition",
    "AnyOf",
    "AtHandle",
    "AtRest",
    "Believed",
    "Beside",
    "BetweenJaws",
    "Bumped",
    "Charged",
    "Charging",
    "Clear",
    "Close",
    "Closer",
    "Commanded",
    "Condition",
    "Cramped",
    "Elapsed",
    "Empty",
    "Facing",
    "Faster",
    "Heading",
    "Holding",
    "HoldsAlone",
    "InView",
    "JawsAt",
    "JointNear",
    "LiesAt",
    "LinedUp",
    "Moving",
    "NarrowPassage",
    "Near",
    "Not",
    "NotDriven",
    "OffPoint",
    "OnCourse",
    "Opening",
    "Over",
    "Raised",
    "Reached",
    "SoleHolder",
    "Still",
    "Travelled",
    "Turned",
    "Vacant",
    "Verdict",
    "in_words",
    "unmet",
]
