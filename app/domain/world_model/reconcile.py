"""Beliefs after a script ended early: by what the robot perceives, not by the effects of actions it had begun."""

from collections.abc import Collection, Sequence

from app.domain.world_model.beliefs import (
    BROUGHT,
    EMPTY,
    GRIPPER,
    NEAR,
    OBJECT_POSITION,
    OPERABLE,
    REACHES,
    ROBOT_ATTRIBUTE,
    ROBOT_POSITION,
    STATES,
    STRUCTURAL,
    TRANSPORTED,
    VACANT,
    Change,
    Facts,
    belief_change,
    occupants,
    place_of,
    revise_beliefs,
    robots_in,
    spot_of,
    storing,
)
from app.domain.world_model.problem import OBJECT
from app.domain.world_model.vocabulary import planner_fact, symbolic, types_in
from planner import Fact, KnowledgeBase, KnowledgeBaseError
from robots.wire import SymbolicFact


def reconcile_report(
    facts: Facts, robot: str, perceived: Sequence[SymbolicFact], knowledge_base: KnowledgeBase
) -> Change:
    """The change of the facts by what `robot` perceives after it failed or was stopped.

    A robot that reports no place stands on the open floor, at its own spot. An object that it was believed to hold and
    does not is lost, unless it is perceived in a place. `transported` facts of the robot are removed, because its next
    transport starts from where it stands; except for an object that it still holds at its destination. So are those
    that it is between two phases of an action.

    Our choices: without a report on its gripper, a robot holds what it was believed to hold; facts that name another
    robot are ignored, because that robot's own reports are better, and so are those that follow from the world or from
    factsheets; what lies in a place is believed of robots that can get there; with an empty gripper, `at` a place
    counts as `near` it, because only a robot that holds something drives off from `at` (knowledge base).
    """
    if Fact(OPERABLE, (robot,)) in facts:
        return _state_change(facts, robot, perceived)
    known, misfits = _understood(facts, perceived, knowledge_base)
    robots = robots_in(facts)
    places = storing(facts)
    # NOTE: a robot also reports places as vacant that cannot hold an object.
    known = [fact for fact in known if fact.predicate != VACANT or fact.args[0] in places]
    news = [fact for fact in known if _may_say(robot, fact, robots, facts)]
    # A dropped object may be perceived in a place, so the empty gripper comes first.
    news.sort(key=lambda fact: fact.predicate == OBJECT_POSITION)
    stands = [f for f in news if f.predicate == ROBOT_POSITION]
    if (joint := _joint_place(facts, robot, news)) is not None:
        news = [Fact(ROBOT_POSITION, (robot, NEAR, joint)), *(f for f in news if f not in stands)]
    elif not stands:
        news.insert(0, Fact(ROBOT_POSITION, (robot, NEAR, spot_of(robot))))
    elif Fact(ROBOT_ATTRIBUTE, (robot, GRIPPER, EMPTY)) in news:
        news.append(Fact(ROBOT_POSITION, (robot, NEAR, stands[-1].args[2])))
    brought = _brought(facts, robot, news)
    news += [Fact(ROBOT_POSITION, (robot, NEAR, fact.args[5])) for fact in brought]
    gone = {f for f in facts if f.predicate == TRANSPORTED and f.args[1] == robot} - brought
    gone |= {f for f in facts if f.predicate in knowledge_base.under_way and f.args[0] == robot}
    after = revise_beliefs(facts, news, gone)
    lost = [
        f"{item} is lost: {robot} does not hold it any longer"
        for item in occupants(robot, facts)
        if place_of(item, after) is None
    ]
    missing = [
        f"{f.args[0]} is lost: it is no longer in {f.args[2]}"
        for f in sorted(facts)
        if f.predicate == OBJECT_POSITION and f.args[2] != robot and place_of(f.args[0], after) is None
    ]
    return Change(add=after - facts, remove=facts - after, notes=(*lost, *missing, *misfits))


def _state_change(facts: Facts, peripheral: str, perceived: Sequence[SymbolicFact]) -> Change:
    """The change by what a door, hatch or lift says of itself; `half_way` is in none of its states."""
    told = [one for one in perceived if one.args[:1] == (peripheral,)]
    if not told:  # its script ended before it had begun
        return Change()
    before = {f for f in facts if f.predicate in STATES and f.args[0] == peripheral}
    after = {Fact(one.predicate, one.args) for one in told if one.predicate in STATES}
    return Change(add=frozenset(after - before), remove=frozenset(before - after))


def told_by_events(facts: Facts, told: Sequence[SymbolicFact], knowledge_base: KnowledgeBase) -> Change:
    """The change by facts that the events of a robot's packet stand for."""
    known, misfits = _understood(facts, told, knowledge_base)
    change = belief_change(facts, known)
    return Change(add=change.add, remove=change.remove, notes=tuple(misfits))


def _brought(facts: Facts, robot: str, news: Sequence[Fact]) -> frozenset[Fact]:
    """The `transported` facts of objects that the robot still holds at their destination, ready to be put down.

    It may already have driven up to the place to put the object down: it then counts as near it, and may try again.
    """
    stands = {f.args[2] for f in news if f.predicate == ROBOT_POSITION}
    emptied = Fact(ROBOT_ATTRIBUTE, (robot, GRIPPER, EMPTY)) in news
    return frozenset(
        f
        for f in facts
        if f.predicate == TRANSPORTED
        and f.args[1] == robot
        and f.args[5] in stands
        and f.args[0] in occupants(robot, facts)
        and not emptied
    )


def _joint_place(facts: Facts, robot: str, news: Sequence[Fact]) -> str | None:
    """The place of two robots that hold an object together; None if this robot does not.

    Our choice: both are in one place, from which they may carry the object on, whatever beacon each of them perceives:
    where they have brought it, else at the open-floor spot of a partner that is there already, else at its own spot.
    """
    held = () if Fact(ROBOT_ATTRIBUTE, (robot, GRIPPER, EMPTY)) in news else occupants(robot, facts)
    partners = sorted(_holders_of(held, facts) - {robot})
    if not partners:
        return None
    brought = next((f.args[1] for f in facts if f.predicate == BROUGHT and f.args[0] in held), None)
    there = (p for p in partners if Fact(ROBOT_POSITION, (p, NEAR, spot_of(p))) in facts)
    return brought or spot_of(next(there, robot))


def _holders_of(items: Collection[str], facts: Facts) -> frozenset[str]:
    """The robots that hold one of these objects."""
    robots = robots_in(facts)
    return frozenset(
        f.args[2]
        for f in facts
        if f.predicate == OBJECT_POSITION and f.args[0] in items and f.args[2] in robots
    )


def _may_say(robot: str, fact: Fact, robots: frozenset[str], facts: Facts) -> bool:
    """Whether a robot may change what is believed by this: it says nothing of others, nor of places it cannot reach."""
    if fact.predicate in STRUCTURAL or robots.intersection(fact.args) - {robot}:
        return False
    match fact.predicate, fact.args:
        case "object_position", (_, _, ref):
            place = ref
        case "vacant", (place,):
            pass
        case _:
            return True
    return place == robot or Fact(REACHES, (robot, place)) in facts


def _understood(
    facts: Facts, perceived: Sequence[SymbolicFact], knowledge_base: KnowledgeBase
) -> tuple[list[Fact], list[str]]:
    """The percepts in the planner's form, and in words those that are not in the vocabulary."""
    objects = types_in(facts, knowledge_base)
    understood: list[Fact] = []
    misfits: list[str] = []
    for percept in perceived:
        # NOTE: a lost sample is in no fact; the robot that finds it names it again.
        unknown = {name: OBJECT for name in percept.args[:1] if name not in objects}
        try:
            fact = planner_fact(percept, knowledge_base, {**objects, **unknown})
        except KnowledgeBaseError as error:
            misfits.append(f"not understood: {percept} ({error})")
            continue
        if symbolic(fact, knowledge_base) == percept:
            understood.append(fact)
    return understood, misfits
