"""What to believe when a script ended before its time: what the robot perceives, not what it had begun."""

from collections.abc import Sequence

from app.vocabulary import planner_fact, symbolic, types_in
from app.world_model.beliefs import (
    EMPTY,
    GRIPPER,
    NEAR,
    OBJECT_POSITION,
    ROBOT_ATTRIBUTE,
    ROBOT_POSITION,
    TRANSPORTED,
    Change,
    Facts,
    occupants,
    place_of,
    revised,
    robots_in,
    spot_of,
)
from app.world_model.problem import OBJECT
from planner import Fact, KnowledgeBase, KnowledgeBaseError
from robots.wire import SymbolicFact


def reconciled(
    facts: Facts, robot: str, perceived: Sequence[SymbolicFact], knowledge_base: KnowledgeBase
) -> Change:
    """How the facts change by what `robot` perceives after it failed or was stopped.

    A robot that names no place it is at stands on the open floor, at its own spot. An object that it was
    believed to hold and does not is lost unless it is perceived where it lies. `transported` of the robot is
    given up: its next transport starts from where it stands.

    Our choices: a robot that says nothing of its gripper holds what it was believed to hold; what it says of
    another robot is not taken, for that robot knows better; with an empty gripper, at a place counts as near
    it, for only what holds something drives off from there (knowledge base).
    """
    known, misfits = _understood(facts, perceived, knowledge_base)
    news = [fact for fact in known if not _of_another(fact, robot, robots_in(facts))]
    # What it dropped may be perceived where it lies, so the empty gripper comes first.
    news.sort(key=lambda fact: fact.predicate == OBJECT_POSITION)
    places = [f for f in news if f.predicate == ROBOT_POSITION]
    if not places:
        news.insert(0, Fact(ROBOT_POSITION, (robot, NEAR, _open_floor(robot, facts, news))))
    elif Fact(ROBOT_ATTRIBUTE, (robot, GRIPPER, EMPTY)) in news:
        news.append(Fact(ROBOT_POSITION, (robot, NEAR, places[-1].args[2])))
    gone = {f for f in facts if f.predicate == TRANSPORTED and f.args[1] == robot}
    after = revised(facts, news, gone)
    lost = [
        f"{item} is lost: {robot} does not hold it any more"
        for item in occupants(robot, facts)
        if place_of(item, after) is None
    ]
    missing = [
        f"{f.args[0]} is lost: it is no longer in {f.args[2]}"
        for f in sorted(facts)
        if f.predicate == OBJECT_POSITION and f.args[2] != robot and place_of(f.args[0], after) is None
    ]
    return Change(add=after - facts, remove=facts - after, notes=(*lost, *missing, *misfits))


def _open_floor(robot: str, facts: Facts, news: Sequence[Fact]) -> str:
    """Its own spot; its partner's if the two hold an object between them and the other stands there already.

    Our choice: so they stand in one place, from which both may carry the object on.
    """
    held = () if Fact(ROBOT_ATTRIBUTE, (robot, GRIPPER, EMPTY)) in news else occupants(robot, facts)
    partners = sorted(f.args[2] for f in facts if f.predicate == OBJECT_POSITION and f.args[0] in held)
    for other in partners:
        if other != robot and Fact(ROBOT_POSITION, (other, NEAR, spot_of(other))) in facts:
            return spot_of(other)
    return spot_of(robot)


def _of_another(fact: Fact, robot: str, robots: frozenset[str]) -> bool:
    """True if the fact is about where another robot is, its attributes, or what it holds."""
    match fact.predicate, fact.args:
        case (("robot_position" | "robot_attribute"), (other, *_)):
            return other != robot
        case "object_position", (_, _, ref):
            return ref in robots and ref != robot
        case _:
            return False


def _understood(
    facts: Facts, perceived: Sequence[SymbolicFact], knowledge_base: KnowledgeBase
) -> tuple[list[Fact], list[str]]:
    """The percepts in the planner's form, and in words those that are not of the vocabulary."""
    objects = types_in(facts, knowledge_base)
    understood, misfits = [], []
    for percept in perceived:
        # NOTE: a lost sample is in no fact any more; the robot that finds it names it again.
        unknown = {name: OBJECT for name in percept.args[:1] if name not in objects}
        try:
            fact = planner_fact(percept, knowledge_base, {**objects, **unknown})
        except KnowledgeBaseError as error:
            misfits.append(f"not understood: {percept} ({error})")
            continue
        if symbolic(fact, knowledge_base) == percept:
            understood.append(fact)
    return understood, misfits
