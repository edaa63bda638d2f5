"""Reservations: the robots, places and samples that a mission still needs, and those that a new plan would reserve.

Two missions that share none of these cannot disturb each other, whatever their delays.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from app.domain.world_model.beliefs import FOLLOWING, OBJECT_POSITION, ROBOT_POSITION, TRANSPORTED, robots_in
from planner import Fact, PlanNet, PlanNetAction


@dataclass(frozen=True, slots=True, kw_only=True)
class Reservation:
    """Robots, locations (zones for one robot among them) and samples in use."""

    robots: frozenset[str] = frozenset()
    locations: frozenset[str] = frozenset()
    samples: frozenset[str] = frozenset()

    @property
    def names(self) -> frozenset[str]:
        return self.robots | self.locations | self.samples

    def shared(self, other: "Reservation") -> tuple[str, ...]:
        """The names in both, in alphabetical order."""
        return tuple(sorted(self.names & other.names))

    def overlaps(self, other: "Reservation") -> bool:
        return bool(self.names & other.names)


NOTHING_RESERVED = Reservation()


def union_of(reservations: Iterable[Reservation]) -> Reservation:
    """Everything that one of them reserves."""
    every = list(reservations)
    return Reservation(
        robots=frozenset().union(*(one.robots for one in every)),
        locations=frozenset().union(*(one.locations for one in every)),
        samples=frozenset().union(*(one.samples for one in every)),
    )


def needed_by(action: PlanNetAction) -> Reservation:
    """Everything that the action names, including the place that it leaves; needed until it has ended."""
    named = named_in((*action.preconditions, *action.deletes, *action.effects))
    return union_of([named, Reservation(robots=frozenset(action.agents))])


def taken_by(plan_net: PlanNet) -> Reservation:
    """What a plan-net reserves once it starts.

    Not the places that its robots only leave: a robot may leave a place that another mission needs.
    """
    return union_of(_taken_by(action) for action in plan_net.actions)


def _taken_by(action: PlanNetAction) -> Reservation:
    facts = [f for f in (*action.preconditions, *action.deletes) if f.predicate != ROBOT_POSITION]
    facts += [f for f in action.effects if f.predicate not in FOLLOWING]
    samples = [f for f in facts if f.predicate == TRANSPORTED]  # also names the place that is left
    named = named_in(f for f in facts if f.predicate != TRANSPORTED)
    return union_of([named, _samples_of(samples), Reservation(robots=frozenset(action.agents))])


def filled_by(actions: Iterable[PlanNetAction]) -> frozenset[str]:
    """The locations, and the robots, that the actions put a sample in."""
    return frozenset(
        fact.args[2] for action in actions for fact in action.effects if fact.predicate == OBJECT_POSITION
    )


def named_in(facts: Iterable[Fact]) -> Reservation:
    """The robots, locations and samples that the facts name."""
    known = list(facts)
    robots = robots_in(known)
    locations = frozenset(place for fact in known for place in _locations(fact)) - robots
    named = Reservation(robots=robots, locations=locations)
    return union_of([named, _samples_of(known)])


def _samples_of(facts: Iterable[Fact]) -> Reservation:
    kinds = {OBJECT_POSITION, TRANSPORTED}
    return Reservation(samples=frozenset(f.args[0] for f in facts if f.predicate in kinds))


def _locations(fact: Fact) -> Sequence[str]:
    match fact.predicate, fact.args:
        case (("robot_position" | "object_position"), (_, _, ref)):
            return (ref,)
        case (("vacant" | "clear" | "zone_clear"), (location, *_)):
            return (location,)
        case "transported", (_, _, _, ref1, _, ref2):
            return (ref1, ref2)
        case _:
            return ()


def is_withheld(fact: Fact, reserved: Reservation) -> bool:
    """True if a plan that must not use the reserved things must not depend on the fact.

    Without these facts no plan moves a reserved robot or sample, goes to a reserved place or uses what lies
    there; robots that stand at one may leave it.
    """
    match fact.predicate, fact.args:
        case (("can" | "in_area" | "operable"), (robot, *_)):
            return robot in reserved.robots
        case (("clear" | "vacant" | "zone_clear"), (location, *_)):
            return location in reserved.locations
        case "reaches", (_, location):
            return location in reserved.locations
        case "object_position", (sample, _, ref):
            return sample in reserved.samples or ref in reserved.locations or ref in reserved.robots
        case _:
            return False
