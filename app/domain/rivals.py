"""What others tell that rules out what a robot reports to have ended: a grip, a release, an arrival. Pure.

A robot that has gripped a compact thing holds it alone until it has released it, and one robot of an area stands at a
place. Only what is dated counts: a report that has not come yet shows nothing.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from math import dist

from app.domain.contradictions import BEGUN, CLOCKS_S, Parts, Told
from app.domain.world_model.beliefs import CLEAR, OBJECT_POSITION, ROBOT_POSITION
from app.domain.world_model.timeliness import DatedFact
from planner import Fact, PlanNet
from robots.wire import PacketState, Telemetry

HANDED_OVER_S = 5.0
"""World seconds that it takes at least to bring a thing on and have another robot grip it, or to make way for a robot
and come back after it (our choice)."""
OCCUPIED_M = 1.2
"""Greatest distance from a place of the robot that stands there: approach points are 0.8 m before it (our choice)."""
Say = Callable[[Fact], str]
"""A fact in words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """A robot's report that its part of an action has ended.

    :param parts: what is recorded of the plan's scripts.
    :param given_at_s: when the robot was given its script (world's clock), None if that is not known.
    """

    net: PlanNet
    action: str
    robot: str
    at_s: float
    parts: Parts
    given_at_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """A robot's newest telemetry.

    :param holding_since_s: when its telemetry first showed what it holds now.
    """

    robot: str
    telemetry: Telemetry
    holding_since_s: float | None = None

    def told(self, **what: str) -> Told:
        known = self.telemetry
        return Told(
            robot=self.robot,
            packet=known.packet_id or "",
            tag=known.packet_tag or "",
            state=known.packet_state or PacketState.WAITING,
            at_s=known.at_s,
            **what,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Rival:
    """Something told that does not fit to the report.

    :param things: where these are, nobody's report tells.
    :param is_certain: news that may be under way cannot explain it.
    """

    told: Told
    things: tuple[str, ...] = ()
    is_certain: bool = True


def gripped_alone(net: PlanNet, action: str, robot: str) -> frozenset[str]:
    """What the action puts into the robot's gripper and no other holds then."""
    known = net.action(action)
    places = [fact for fact in known.preconditions if fact.predicate == OBJECT_POSITION]
    shared = {fact.args[0] for fact in places if fact.args[2] in net.robots}
    return frozenset(
        fact.args[0]
        for fact in known.effects
        if fact.predicate == OBJECT_POSITION and fact.args[2] == robot and fact.args[0] not in shared
    )


def released_alone(net: PlanNet, action: str, robot: str) -> frozenset[str]:
    """What the action takes from the robot's gripper, which alone holds it, to a place."""
    known = net.action(action)
    held = {fact.args[0]: fact.args[2] for fact in known.preconditions if fact.predicate == OBJECT_POSITION}
    shared = {
        fact.args[0]
        for fact in known.preconditions
        if fact.predicate == OBJECT_POSITION and fact.args[2] != robot
    }
    put = {
        fact.args[0]
        for fact in known.effects
        if fact.predicate == OBJECT_POSITION and fact.args[2] not in net.robots
    }
    return frozenset(thing for thing, holder in held.items() if holder == robot) & put - shared


def arrives_at(net: PlanNet, action: str, robot: str) -> tuple[str, str] | None:
    """The place and area that the action takes the robot to and that it alone may stand at."""
    known = net.action(action)
    ends = {f.args[2] for f in known.effects if f.predicate == ROBOT_POSITION and f.args[0] == robot}
    kept = (f.args for f in known.preconditions if f.predicate == CLEAR and f.args[0] in ends)
    return next(((place, area) for place, area in kept), None)


def held_since_s(ended: Ended, thing: str) -> float | None:
    """When the robot has gripped what it reports to have released, by its own report; None if that has not come."""
    before = ended.net.of_robot(ended.robot)
    before = before[: [one.id for one in before].index(ended.action)]
    grip = next((one for one in reversed(before) if _grips(one.effects, thing, ended.robot)), None)
    if grip is None:
        return ended.given_at_s
    known = ended.parts.get((grip.id, ended.robot), {})
    if known.get("state") != PacketState.FINISHED or known.get("implied"):
        return None
    return float(known["finished_at_s"])


def holder_after_grip(ended: Ended, others: Iterable[Seen]) -> Rival | None:
    """A robot whose telemetry shows it to hold what this one has gripped just before.

    Later telemetry shows nothing: the thing may have been handed over.
    """
    things = gripped_alone(ended.net, ended.action, ended.robot)
    for seen in others if things else ():
        held, at_s = seen.telemetry.holding, seen.telemetry.at_s
        if held and held in things and ended.at_s < at_s <= ended.at_s + HANDED_OVER_S:
            told = seen.told(holding=held)
            return Rival(told=told, things=(held,), is_certain=at_s - ended.at_s > CLOCKS_S)
    return None


def holder_until_release(ended: Ended, others: Iterable[Seen]) -> Rival | None:
    """A robot whose telemetry shows it to hold, between this one's grip and its release, what this one releases."""
    things = released_alone(ended.net, ended.action, ended.robot)
    for seen in others if things else ():
        held = seen.telemetry.holding
        from_s = held_since_s(ended, held) if held and held in things else None
        if held is None or from_s is None or seen.holding_since_s is None:
            continue
        if _is_between(seen.holding_since_s, seen.telemetry.at_s, from_s=from_s, to_s=ended.at_s):
            return Rival(told=seen.told(holding=held), things=(held,))
    return None


def place_until_release(
    ended: Ended, beliefs: Collection[DatedFact], say: Say, *, own_source: str
) -> Rival | None:
    """A belief, newer than this robot's grip and older than its release, that has elsewhere what it releases.

    :param own_source: of what this robot has reported.
    """
    for thing in sorted(released_alone(ended.net, ended.action, ended.robot)):
        from_s = held_since_s(ended, thing)
        for one in beliefs:
            is_about = one.fact.predicate == OBJECT_POSITION and one.fact.args[0] == thing
            if from_s is None or not is_about or one.fact.args[2] == ended.robot or one.source == own_source:
                continue
            if _is_between(one.at_s, one.at_s, from_s=from_s, to_s=ended.at_s):
                return Rival(told=_believed(one, say), things=(thing,))
    return None


def occupants(ended: Ended, beliefs: Collection[DatedFact], areas: Collection[Fact]) -> Iterator[DatedFact]:
    """The beliefs by which another robot of the area stands at the place where this one reports to have arrived.

    :param areas: `in_area` of the robots.
    """
    target = arrives_at(ended.net, ended.action, ended.robot)
    agents = ended.net.action(ended.action).agents
    for one in beliefs if target is not None else ():
        if target is None or one.fact.predicate != ROBOT_POSITION or one.fact.args[2] != target[0]:
            continue
        robot = one.fact.args[0]
        is_here = any(fact.args == (robot, target[1]) for fact in areas)
        if is_here and robot not in agents and one.at_s < ended.at_s - CLOCKS_S:
            yield one


def shows_occupant(
    ended: Ended, belief: DatedFact, seen: Seen, place_at: tuple[float, float]
) -> Rival | None:
    """The robot's telemetry, if it shows just after the arrival that it still stands at the place.

    One that has begun what takes it away shows nothing.
    """
    told = seen.telemetry
    if not ended.at_s + CLOCKS_S < told.at_s <= ended.at_s + HANDED_OVER_S:
        return None
    if dist(place_at, (told.x_m, told.y_m)) > OCCUPIED_M or may_have_left(ended, belief.fact, told):
        return None
    return Rival(told=seen.told(place=belief.fact.args[2]))


def believed_occupant(belief: DatedFact, say: Say, *, is_certain: bool) -> Rival:
    """The belief about a robot that is not at work, so that nothing takes it away."""
    return Rival(told=_believed(belief, say), is_certain=is_certain)


def may_have_left(ended: Ended, position: Fact, telemetry: Telemetry | None) -> bool:
    """True if the robot is known to have begun what takes it from its position, or to be at work on another plan."""
    robot = position.args[0]
    own = {one.id: one for one in ended.net.actions if robot in one.agents}
    if any(
        position in one.deletes and ended.parts.get((one.id, robot), {}).get("state") in BEGUN
        for one in own.values()
    ):
        return True
    if telemetry is None or telemetry.packet_state is not PacketState.RUNNING:
        return False
    under_way = own.get(telemetry.packet_id or "")
    return under_way is None or position in under_way.deletes


def _is_between(first_s: float, last_s: float, *, from_s: float, to_s: float) -> bool:
    """True if a part of the first span lies in the second by more than two robots' clocks may differ."""
    return first_s < to_s - CLOCKS_S and last_s > from_s + CLOCKS_S


def _grips(effects: Iterable[Fact], thing: str, robot: str) -> bool:
    return any(
        fact.predicate == OBJECT_POSITION and fact.args[0] == thing and fact.args[2] == robot
        for fact in effects
    )


def _believed(one: DatedFact, say: Say) -> Told:
    return Told(
        robot=one.source,
        packet="",
        tag="",
        state=PacketState.WAITING,
        at_s=one.at_s,
        believed=say(one.fact),
    )
