"""The rules of recovery, as pure functions: a mission's troubles, what is left out of planning, what may be tried.

In this order: the rest of the same plan, if its pre-conditions hold; a repair that keeps what is done; a plan without
the robots that can no longer be used; the operator.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any, Self

from app.domain.tender_document import LegBody
from app.domain.world_model.beliefs import CAN, OPERABLE, Facts
from planner import PlanNet
from planner.repair import Course
from robots.wire import FailureCategory
from robots.world.peripherals import PERIPHERAL_TAGS

TRIES = 4
"""How often a mission is recovered before an operator is asked, or it has failed (our choice)."""
FAILURES = 2
"""Number of failures of a robot at one packet after which the mission does not plan that packet for it (our choice)."""


class Policy(StrEnum):
    """How a mission is to be recovered."""

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
    """Why a robot did not finish its script.

    :param tag: the packet that it failed at; empty if that is not known.
    :param fit: the robot may be planned with again.
    :param waited: it timed out waiting for another robot, and did not fail itself.
    :param script: the id of the script; empty in old records.
    :param about: the things and places that the packet was about.
    :param answered: an operator has dealt with it, or the lost robot was found: it no longer counts against the robot.
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
        """True if the robot was declared lost and is not found."""
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
    """The requested policy; by default repairs are approved automatically if the plan is."""
    if wish is not None:
        return Policy(wish)
    return Policy.AUTO if auto_approve else Policy.ASK


def category_of(troubles: Sequence[Trouble]) -> FailureCategory:
    """The category for the mission: unreachable if any trouble is, else that of the first trouble.

    Without any trouble the category is that the world has changed.
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
        failing = {name for name, _ in self.packets}  # a door that does not open is not planned with
        return frozenset(
            fact
            for fact in facts
            if not (fact.predicate == CAN and fact.args in self.packets)
            and not (fact.predicate == OPERABLE and fact.args[0] in failing)
        )

    def concerns(self, plan_net: PlanNet) -> bool:
        """True if the plan-net uses one of these robots or packets."""
        parts = {(robot, action.tag) for action in plan_net.actions for robot in action.agents}
        return not self.packets.isdisjoint(parts) or any(robot in self.robots for robot, _ in parts)


def left_out(troubles: Iterable[Trouble]) -> LeftOut:
    """What repairs must not use: robots that are lost or refused a script, and packets that a robot failed at twice.

    A door that does not open and one that does not stay open or closed fail alike.

    :param troubles: all of the mission so far; answered ones do not count.
    """
    had = [one for one in troubles if not (one.waited or one.answered)]
    failures = Counter((one.robot, _counted(one.tag)) for one in had)
    often = {(one.robot, one.tag) for one in had if failures[one.robot, _counted(one.tag)] >= FAILURES}
    unfit = {one.robot for one in had if not one.fit} | {robot for robot, tag in often if not tag}
    return LeftOut(
        robots=frozenset(unfit),
        packets=frozenset((robot, tag) for robot, tag in often if robot not in unfit),
    )


def has_failed_at(troubles: Iterable[Trouble], leg: LegBody, robot: str) -> bool:
    """True if the robot has had trouble at a leg that it was awarded: at something that the leg's goal names.

    Where it is not known at what, and where the robot cannot be used any longer, that is all its legs.
    """
    return any(
        one.robot == robot
        and not (one.waited or one.answered)
        and (not one.fit or not one.about or not set(leg.goal.args).isdisjoint(one.about))
        for one in troubles
    )


def _counted(tag: str) -> str:
    """What failures at a packet are counted as."""
    return "peripheral" if tag in PERIPHERAL_TAGS else tag


def measure_of(course: Course, *, without: bool) -> Measure:
    """The measure that a repaired plan is; `without`: a robot or packet of the old plan is left out."""
    if without:
        return Measure.REPLAN
    return Measure.RETRY if course is Course.KEPT else Measure.REPAIR


def needs_decision(policy: Policy, measure: Measure) -> bool:
    """True if an operator is to decide. The unchanged rest of an approved plan needs no second approval."""
    return policy is Policy.ASK and measure is not Measure.RETRY
