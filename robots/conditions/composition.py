"""Composite conditions, and the type of any condition that data may state."""

from collections.abc import Iterable
from typing import Annotated

from robots.conditions import beliefs, long_objects, motion, own_state, position, sight  # noqa: F401, define conditions
from robots.conditions.verdict import Condition, Verdict
from robots.data import ChosenBy
from robots.extensions import CONDITIONS
from robots.perception.percepts import NOTHING, Needs, Percepts

AnyCondition = Annotated[Condition, ChosenBy("sense", CONDITIONS)]


class Not(Condition):
    """The condition does not hold."""

    of: AnyCondition

    @property
    def needs(self) -> Needs:
        return self.of.needs

    @property
    def quantities(self) -> frozenset[str]:
        return self.of.quantities

    def check(self, percepts: Percepts) -> Verdict:
        verdict = self.of.check(percepts)
        return Verdict(not verdict.holds, verdict.words)


class AnyOf(Condition):
    """At least one of the conditions holds."""

    of: tuple[AnyCondition, ...]

    @property
    def needs(self) -> Needs:
        return NOTHING.union(*(one.needs for one in self.of))

    @property
    def quantities(self) -> frozenset[str]:
        return frozenset[str]().union(*(one.quantities for one in self.of))

    def check(self, percepts: Percepts) -> Verdict:
        verdicts = [one.check(percepts) for one in self.of]
        holds = any(one.holds for one in verdicts)
        unseen = not holds and any(one.unseen for one in verdicts)
        return Verdict(holds, in_words(verdicts), unseen)


class AllOf(Condition):
    """Every one of the conditions holds."""

    of: tuple[AnyCondition, ...]

    @property
    def needs(self) -> Needs:
        return NOTHING.union(*(one.needs for one in self.of))

    @property
    def quantities(self) -> frozenset[str]:
        return frozenset[str]().union(*(one.quantities for one in self.of))

    def check(self, percepts: Percepts) -> Verdict:
        verdicts = [one.check(percepts) for one in self.of]
        unseen = any(one.unseen for one in verdicts)
        return Verdict(all(one.holds for one in verdicts), in_words(verdicts), unseen)


def unmet(conditions: Iterable[Condition], percepts: Percepts) -> list[Verdict]:
    """The verdict, with what was perceived instead, of every condition that does not hold."""
    return [verdict for condition in conditions if not (verdict := condition.check(percepts)).holds]


def in_words(verdicts: Iterable[Verdict]) -> str:
    return "; ".join(verdict.words for verdict in verdicts)
