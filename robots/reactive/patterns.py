"""Behaviour patterns: a response and a utility, each a function of one stimulus (MACTA §3, eq. 1)."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated

from robots.conditions.composition import AnyCondition
from robots.data import ChosenBy, StrEnum, Strict
from robots.extensions import STIMULI
from robots.perception.percepts import Percepts
from robots.reactive import carrying, kicking, steering  # noqa: F401, define stimuli
from robots.reactive.responses import AnyResponse
from robots.reactive.stimuli import Stimulus
from robots.reactive.synthesis import REST, DegreeOfFreedom, Resultants, Utilitor, synthesise


class Level(StrEnum):
    """The four behaviour levels of the BSA (MACTA §3, fig. 2)."""

    SELF = "self"
    ENVIRONMENT = "environment"
    SPECIES = "species"
    TASK = "task"


class BehaviourPattern(Strict):
    """bp = [f_r(s), f_u(s)] on one degree of freedom.

    `when`: the context outside of which the utility is zero whatever the stimulus (MACTA §3 asks for that between
    packets; within one it is our choice).
    """

    name: str
    dof: DegreeOfFreedom
    level: Level
    stimulus: Annotated[Stimulus, ChosenBy("sense", STIMULI)]
    r: AnyResponse
    u: AnyResponse
    when: tuple[AnyCondition, ...] = ()

    @cached_property
    def label(self) -> str:
        """Its name in telemetry: "dof/name"."""
        return f"{self.dof}/{self.name}"

    def respond(self, percepts: Percepts) -> Utilitor:
        """The pattern's utilitor; without utility if the stimulus is not sensed, or out of context."""
        for condition in self.when:
            if not condition.check(percepts).holds:
                return REST
        s = self.stimulus.read(percepts)
        if s is None:
            return REST
        response = max(-1.0, min(1.0, self.r.at(s)))
        return Utilitor.normalised(response, max(0.0, min(1.0, self.u.at(s))))


@dataclass(frozen=True, slots=True)
class Responses:
    """The utilitors of all active patterns in one tick, and the resultants of the synthesis."""

    patterns: tuple[BehaviourPattern, ...] = ()
    answers: tuple[Utilitor, ...] = ()
    resultant: Resultants = field(default_factory=dict)

    @property
    def of(self) -> Sequence[tuple[BehaviourPattern, Utilitor]]:
        """Each pattern with its utilitor."""
        return tuple(zip(self.patterns, self.answers, strict=True))

    def resultants(self) -> dict[str, tuple[float, float]]:
        """Normalised (r, u) of each degree of freedom."""
        return {dof.value: (one.response, one.u) for dof, one in self.resultant.items()}

    def shown(self) -> dict[str, tuple[float, float]]:
        """Normalised (r, u) by "dof/name"."""
        return {one.label: (utilitor.response, utilitor.u) for one, utilitor in self.of}


def respond(patterns: tuple[BehaviourPattern, ...], percepts: Percepts) -> Responses:
    """Evaluate every pattern, and resolve the utilitors of each degree of freedom."""
    answers = tuple([pattern.respond(percepts) for pattern in patterns])
    related: dict[DegreeOfFreedom, list[Utilitor]] = {}
    for pattern, utilitor in zip(patterns, answers, strict=True):
        related.setdefault(pattern.dof, []).append(utilitor)
    return Responses(patterns, answers, synthesise(related))
