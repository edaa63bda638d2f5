"""Outdated reports: a reported fact is not believed if newer facts about the same thing are known.

A reported fact is compared with facts about the same thing: a robot's position, one of its attributes, an object's
position, what lies in a place. `vacant` and `clear` follow from these.
"""

from collections.abc import Collection, Iterable
from dataclasses import dataclass

from app.domain.world_model.beliefs import (
    DERIVED,
    IN_ZONE,
    OBJECT_POSITION,
    ROBOT_ATTRIBUTE,
    ROBOT_POSITION,
    TRANSPORTED,
    Change,
    Facts,
    revise_beliefs,
)
from planner import Fact

Subject = tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class DatedFact:
    """A believed fact with its source and time (world's clock)."""

    fact: Fact
    source: str
    at_s: float


def subjects_of(fact: Fact) -> frozenset[Subject]:
    """The things that the fact is about."""
    match fact.predicate, fact.args:
        case "object_position", (item, _, ref):
            return frozenset({(OBJECT_POSITION, item), ("place", ref)})
        case (("opened" | "closed" | "lift_at"), (name, *_)):
            return frozenset({("peripheral", name)})
        case (("robot_position" | "transported" | "robot_attribute" | "brought" | "holds_alone"), _):
            return frozenset({_subject(fact)})
        case _:
            return frozenset()


def beliefs_contradicting(fact: Fact, believed: Iterable[DatedFact]) -> list[DatedFact]:
    """The beliefs about the same things as a fact that is not believed."""
    believed = tuple(believed)
    match fact.predicate, fact.args:
        case "vacant", (place,):
            return [one for one in believed if ("place", place) in subjects_of(one.fact)]
        case "clear", (place, *_):
            return [
                one for one in believed if one.fact.predicate == ROBOT_POSITION and one.fact.args[2] == place
            ]
        case "zone_clear", (zone,):
            inside = {
                one.fact.args[0]
                for one in believed
                if one.fact.predicate == IN_ZONE and one.fact.args[2] == zone
            }
            return [
                one for one in believed if one.fact.predicate == ROBOT_POSITION and one.fact.args[2] in inside
            ]
        case _:
            about = subjects_of(fact)
            return [one for one in believed if not about.isdisjoint(subjects_of(one.fact))]


def _subject(fact: Fact) -> Subject:
    match fact.predicate, fact.args:
        case "transported", (_, robot, *_):
            return (TRANSPORTED, robot)
        case "robot_attribute", (robot, attribute, _):
            return (ROBOT_ATTRIBUTE, robot, attribute)
        case "brought", (item, *_):
            return (OBJECT_POSITION, item)
        case "holds_alone", (_, item):
            return (OBJECT_POSITION, item)
        case _, (robot, *_):
            return (ROBOT_POSITION, robot)
    raise AssertionError(f"{fact} has no subject")


def newer_subjects(
    known: Iterable[DatedFact], at_s: float, *, but: Collection[str] = ()
) -> frozenset[Subject]:
    """The things about which a newer fact is known.

    :param but: sources whose facts do not count.
    """
    newer = (one.fact for one in known if one.at_s > at_s and one.source not in but)
    return frozenset(subject for fact in newer for subject in subjects_of(fact))


def without_outdated(facts: Facts, change: Change, newer: Collection[Subject]) -> Change:
    """The change without its facts about things about which newer facts are known."""
    said = [f for f in sorted(change.add) if f.predicate not in DERIVED]
    gone = [f for f in sorted(change.remove) if f.predicate not in DERIVED]
    late = {f for f in (*said, *gone) if not subjects_of(f).isdisjoint(newer)}
    # Whether a gripper is full depends on what is in it.
    places = {f.args[2] for f in late if f.predicate == OBJECT_POSITION}
    late |= {f for f in (*said, *gone) if f.predicate == ROBOT_ATTRIBUTE and f.args[0] in places}
    kept = [f for f in said if f not in late]
    kept_gone = [f for f in gone if f not in late]
    if (kept, kept_gone) == (said, gone):
        return change
    after = revise_beliefs(facts, kept, kept_gone)
    return Change(add=after - facts, remove=facts - after, notes=change.notes)
