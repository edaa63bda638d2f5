"""The base class of sensor conditions, and the verdict on one."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

from robots.perception.percepts import Percepts, SensingVariant


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether a condition holds, and what was perceived, in words.

    `unseen`: it does not hold because neither the object nor its place is in view.
    """

    holds: bool
    words: str
    unseen: bool = False


class Condition(SensingVariant, ABC):
    """A sensor condition. Data name the subclass and its fields: `{sense: holding, object: rock}`."""

    @property
    def quantities(self) -> frozenset[str]:
        """What it reads of the quantities that sensors of installed packages measure."""
        return frozenset()

    @abstractmethod
    def check(self, percepts: Percepts) -> Verdict:
        """Whether it holds, by what is perceived in this tick."""
