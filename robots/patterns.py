"""Behaviour patterns: a response and a utility, each a function of one stimulus (MACTA §3, eq. 1)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import ClassVar

from pydantic import ConfigDict

from robots.conditions import AnyCondition
from robots.percepts import Percepts
from robots.responses import STRICT, AnyResponse
from robots.stimuli import AnyStimulus
from robots.synthesis import DegreeOfFreedom, Resultants, Utilitor, synthesise


class Level(StrEnum):
    """The four behaviour levels of the BSA (MACTA §3, fig. 2)."""

    SELF = "self"
    ENVIRONMENT = "environment"
    SPECIES = "species"
    TASK = "task"


@dataclass(frozen=True, slots=True, kw_only=True)
class BehaviourPattern:
    """bp = [f_r(s), f_u(s)] on one degree of freedom.

    `when`: the context within the packet outside of which the utility is forced to zero irrespective of the
    stimulus (MACTA §3 asks for that between packets; within one it is our choice).
    """

    __pydantic_config__: ClassVar[ConfigDict] = STRICT
    name: str
    dof: DegreeOfFreedom
    level: Level
    stimulus: AnyStimulus
    r: AnyResponse
    u: AnyResponse
    when: tuple[AnyCondition, ...] = ()

    def respond(self, percepts: Percepts) -> Utilitor:
        """The utilitor for what is perceived; without stimulus or out of context it has no utility."""
        if not all(condition.check(percepts).holds for condition in self.when):
            return Utilitor(0.0, 0.0)
        s = self.stimulus.read(percepts)
        if s is None:
            return Utilitor(0.0, 0.0)
        response = max(-1.0, min(1.0, self.r.at(s)))
        return Utilitor.normalised(response, max(0.0, min(1.0, self.u.at(s))))


@dataclass(frozen=True, slots=True)
class Responses:
    """What every active pattern answered at one instant, and what the synthesis made of it."""

    of: Sequence[tuple[BehaviourPattern, Utilitor]] = ()
    resultant: Resultants = field(default_factory=dict)

    def resultants(self) -> dict[str, tuple[float, float]]:
        """Normalised (r, u) of each degree of freedom."""
        return {str(dof): (one.response, one.u) for dof, one in self.resultant.items()}

    def shown(self) -> dict[str, tuple[float, float]]:
        """Normalised (r, u) by "dof/name"."""
        return {f"{one.dof}/{one.name}": (utilitor.response, utilitor.u) for one, utilitor in self.of}


def respond(patterns: Iterable[BehaviourPattern], percepts: Percepts) -> Responses:
    """Ask every pattern, and resolve the related utilitors: by degree of freedom."""
    answers = [(pattern, pattern.respond(percepts)) for pattern in patterns]
    related: dict[DegreeOfFreedom, list[Utilitor]] = {}
    for pattern, utilitor in answers:
        related.setdefault(pattern.dof, []).append(utilitor)
    return Responses(answers, synthesise(related))
