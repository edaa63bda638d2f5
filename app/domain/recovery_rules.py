"""The rules of recovery, as pure functions: what has befallen a mission, who is left out, what may be tried.

In this order: the same again, as far as its pre-conditions hold; a repair that keeps what is done; a plan without the
robots that are of no use any longer; the operator.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any, Self

from app.domain.world_model.beliefs import CAN, Facts
from planner import PlanNet
from planner.repair import Course
from robots.wire import FailureCategory

TRIES = 4
"""So often a mission is recovered before an operator is asked, or it has failed (our choice)."""
FAILURES = 2
"""What a robot has failed at so often in a mission it is not planned to do there any longer (our choice)."""


class Policy(StrEnum):
    """What an operator wants of a mission's recovery."""

    AUTO = "auto"
    """Repaired plans are approved at once."""
    ASK = "ask"
    """An operator decides on repaired plans."""
    NEVER = "never"
    """The mission ends with its first failure."""


class Measure(StrEnum):
    """What was done about a failure."""

    RETRY = "retry"
    """The rest of the same plan, as it was."""
    REPAIR = "repair"
    """Another plan by the same robots."""
    REPLAN = "replan"
    """Another plan, without some of the robots, or without what one of them fails at."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Trouble:
    """What kept a robot from doing its part.

    :param tag: the packet that it failed at; empty if that is not known.
    :param fit: it may be planned with again.
    :param waited: it waited in vain for what another was to do, and has not failed at anything itself.
    :param script: the id of the script that it could not carry out; empty in old records.
    :param about: the things and places that the packet was about.
    :param answered: an operator has seen to it, or the lost robot was found: it speaks against the robot no more.
    """

    robot: str
    category: FailureCategory
    detail: str
    tag: str = ""
    fit: bool = True
    waited: bool = False
    script: str = ""
    about: tuple[str, ...] = ()
    answered: bool = False

    @property
    def is_loss(self) -> bool:
        """True if it is that the robot was declared lost."""
        return self.category is FailureCategory.UNREACHABLE and not self.fit

    def is_answered_by(self, names: Collection[str]) -> bool:
        """True if a correction that names these robots, things and places may have removed its cause."""
        return not self.is_loss and (self.robot in names or any(name in names for name in self.about))

    def __str__(self) -> str:
        return f"{self.robot}: {self.detail}" if self.detail else self.robot

    def to_json(self) -> dict[str, Any]:
        return asdict(self) | {"category": self.category.value}

    @classmethod
    def from_json(cls, known: Mapping[str, Any]) -> Self:
        told = {"category": FailureCategory(known["category"]), "about": tuple(known.get("about", ()))}
        return cls(**{**known, **told})


def policy_for(wish: str | None, *, auto_approve: bool) -> Policy:
    """What was asked for; else who wanted to see the plan wants to see its repairs."""
    if wish is not None:
        return Policy(wish)
    return Policy.AUTO if auto_approve else Policy.ASK


def category_of(troubles: Sequence[Trouble]) -> FailureCategory:
    """One for the mission: silence first, for it is what the least is known of; else what came first.

    Without any trouble of a robot's the world is not as it was believed to be.
    """
    if any(one.category is FailureCategory.UNREACHABLE for one in troubles):
        return FailureCategory.UNREACHABLE
    return troubles[0].category if troubles else FailureCategory.WORLD_CHANGED


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """Robots, and single packets of robots, that a mission's repairs must not use.

    A robot that failed at one packet may still carry out others, such as driving out of the way.
    """

    robots: frozenset[str] = frozenset()
    packets: frozenset[tuple[str, str]] = frozenset()

    @property
    def words(self) -> tuple[str, ...]:
        return (*sorted(self.robots), *(f"{tag} by {robot}" for robot, tag in sorted(self.packets)))

    def remove_from(self, facts: Facts) -> Facts:
        """The facts without those that allow these packets."""
        return frozenset(f for f in facts if f.predicate != CAN or f.args not in self.packets)

    def concerns(self, plan_net: PlanNet) -> bool:
        """True if the plan-net uses one of these robots or packets."""
        parts = {(robot, action.tag) for action in plan_net.actions for robot in action.agents}
        return not self.packets.isdisjoint(parts) or any(robot in self.robots for robot, _ in parts)


def left_out(troubles: Iterable[Trouble]) -> LeftOut:
    """Robots that are lost or unwilling, and what a robot has failed at for the second time. What is answered does not
    count.

    :param troubles: all that the mission has had so far.
    """
    had = [one for one in troubles if not (one.waited or one.answered)]
    often = {
        known for known, times in Counter((one.robot, one.tag) for one in had).items() if times >= FAILURES
    }
    unfit = {one.robot for one in had if not one.fit} | {robot for robot, tag in often if not tag}
    return LeftOut(
        robots=frozenset(unfit),
        packets=frozenset((robot, tag) for robot, tag in often if robot not in unfit),
    )


def measure_of(course: Course, *, without: bool) -> Measure:
    """What a repaired plan amounts to; `without`: something of the old plan is left out."""
    if without:
        return Measure.REPLAN
    return Measure.RETRY if course is Course.KEPT else Measure.REPAIR


def needs_decision(policy: Policy, measure: Measure) -> bool:
    """True if an operator is to decide. The rest of what was approved, as it was, is approved already."""
    return policy is Policy.ASK and measure is not Measure.RETRY
