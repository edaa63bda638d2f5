"""A long trial of the service: goals and faults drawn by chance; what it says is held against the world's truth.

A client of the API like any other, and the one who kills: `macta serve` runs as a child process. The simulated world's
truth is the command line's to read. Beside `macta soak` the tests' storms are made of these parts.
"""

from app.soak.faults import Faults, Mishap
from app.soak.judge import (
    Found,
    disagreements,
    executed_twice,
    goals_that_did_not_come_true,
    lost_events,
    open_for_ever,
)
from app.soak.life import Installation, Life, NotReady, holder_of
from app.soak.operator import RandomOperator
from app.soak.record import Record
from app.soak.trial import Quiet, Trial
from app.soak.watch import Watch, numbers

__all__ = [
    "Faults",
    "Found",
    "Installation",
    "Life",
    "Mishap",
    "NotReady",
    "Quiet",
    "RandomOperator",
    "Record",
    "Trial",
    "Watch",
    "disagreements",
    "executed_twice",
    "goals_that_did_not_come_true",
    "holder_of",
    "lost_events",
    "numbers",
    "open_for_ever",
]
