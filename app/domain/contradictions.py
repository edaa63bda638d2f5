"""Whether what robots report of their parts of one plan fits together. Pure.

A robot that waits for clearance begins after the actions that it waits for have ended; one that senses what another
brings about begins after that one has begun, for a fact may come true before the end of the action that brings it
about. A part that its robot reports to have begun earlier contradicts the other robot's report. What the other has
told it itself may be reported later.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Self

from app.domain.world_model.beliefs import OBJECT_POSITION
from planner import Keeping, Ordering, PlanNet
from robots.wire import PacketState

CLOCKS_S = 1.5
"""World seconds by which the clocks of two robots may differ (our choice)."""
HELD_S = 30.0
"""World seconds for which a report is held back until the one that it contradicts without has come (our choice)."""
BEGUN = frozenset(PacketState) - {PacketState.WAITING, PacketState.INITIALIZING}

Parts = Mapping[tuple[str, str], Mapping[str, Any]]
"""By action id and robot, what is recorded of the robot's part: `state`, `at_s`, `started_at_s`, `finished_at_s`;
`claimed_at_s`: when it said that it had begun without clearance; `implied`: its end follows from that of its script;
`cleared_by`: by action that it waited for, the robots that have told it of its end."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Told:
    """What a robot has reported of its part of an action, what its telemetry shows, or what the record has.

    :param robot: or the source of what is believed.
    :param at_s: world's clock; None: it has reported nothing of it, and `state` is `waiting`.
    :param holding: what its telemetry shows it to hold then; empty if this is no such telemetry.
    :param place: likewise the place at which it stands.
    :param believed: the recorded fact, in words; empty if this is a robot's report or telemetry.
    """

    robot: str
    packet: str
    tag: str
    state: PacketState
    at_s: float | None
    holding: str = ""
    place: str = ""
    believed: str = ""

    @property
    def is_report(self) -> bool:
        """True if it is a robot's report of its part, whose place in the order of the plan counts."""
        return not (self.holding or self.place or self.believed)

    def __str__(self) -> str:
        what = f"{self.packet} {self.tag}"
        if self.at_s is None:
            return f"{self.robot} has reported nothing of {what}"
        if self.believed:
            return f"the record has {self.believed} at {self.at_s:.1f} s ({self.robot})"
        if self.holding:
            return f"{self.robot} holds {self.holding} by its telemetry at {self.at_s:.1f} s"
        if self.place:
            return f"{self.robot} stands at {self.place} by its telemetry at {self.at_s:.1f} s"
        verb = {PacketState.RUNNING: "begun", PacketState.FINISHED: "ended"}.get(self.state)
        if verb is None:
            return f"{self.robot} reports {what} as {self.state.value} at {self.at_s:.1f} s"
        return f"{self.robot} reports to have {verb} {what} at {self.at_s:.1f} s"


@dataclass(frozen=True, slots=True, kw_only=True)
class Contradiction:
    """Two reports that do not fit together.

    :param plan_id: the plan whose actions they are about.
    :param things: what the earlier action hands over to the later one; where it is, nobody's report tells.
    """

    plan_id: str
    earlier: Told
    later: Told
    things: tuple[str, ...]

    @property
    def key(self) -> tuple[str, ...]:
        """The same for all contradictions between these parts of these robots."""
        return (self.plan_id, *(part for told in self.reports for part in (told.packet, told.robot)))

    @property
    def reports(self) -> tuple[Told, Told]:
        return self.earlier, self.later

    def __str__(self) -> str:
        order = f"{self.later.packet} comes after {self.earlier.packet}"
        if not self.earlier.is_report:
            order = "only one of them can be so"
        who = f"the reports of {self.later.robot} and {self.earlier.robot}"
        if self.earlier.believed:
            who = f"the report of {self.later.robot} and the record"
        return f"{who} contradict each other: {self.later}, but {self.earlier}; {order}"

    def to_json(self) -> dict[str, Any]:
        return asdict(self) | {"things": list(self.things), "detail": str(self)}

    @classmethod
    def from_json(cls, known: Mapping[str, Any]) -> Self:
        earlier, later = (
            Told(**{**known[name], "state": PacketState(known[name]["state"])})
            for name in ("earlier", "later")
        )
        return cls(
            plan_id=known["plan_id"], earlier=earlier, later=later, things=tuple(known.get("things", ()))
        )


def contradictions(net: PlanNet, parts: Parts, *, plan_id: str) -> Sequence[Contradiction]:
    """The pairs of recorded reports that do not fit together, in the order of the plan's orderings."""
    return [
        Contradiction(plan_id=plan_id, earlier=earlier, later=later, things=_handed_over(net, ordering))
        for ordering in net.orderings
        for earlier, later in _contradicting(net, ordering, parts)
    ]


def told_of(net: PlanNet, parts: Parts, action: str, robot: str) -> Told:
    """The newest that the robot has reported of its part."""
    known = parts.get((action, robot), {})
    return Told(
        robot=robot,
        packet=action,
        tag=net.action(action).tag,
        state=PacketState(known.get("state", PacketState.WAITING)),
        at_s=known.get("at_s"),
    )


def _contradicting(net: PlanNet, ordering: Ordering, parts: Parts) -> Iterator[tuple[Told, Told]]:
    if ordering.kept_by is Keeping.ROBOT:
        return
    tag = net.action(ordering.after).tag
    doers = net.action(ordering.before).agents
    for robot in net.action(ordering.after).agents:
        known = parts.get((ordering.after, robot), {})
        said = [known[name] for name in ("claimed_at_s", "started_at_s", "finished_at_s") if name in known]
        if not said or known["state"] not in BEGUN:
            continue
        begun_s = min(said)
        state = PacketState.FINISHED if begun_s == known.get("finished_at_s") else PacketState.RUNNING
        later = Told(robot=robot, packet=ordering.after, tag=tag, state=state, at_s=begun_s)
        for other in doers:
            is_told = other in known.get("cleared_by", {}).get(ordering.before, ())
            if other != robot and _is_too_early(net, ordering, other, begun_s, parts, is_told=is_told):
                yield told_of(net, parts, ordering.before, other), later


def _is_too_early(
    net: PlanNet, ordering: Ordering, other: str, begun_s: float, parts: Parts, *, is_told: bool
) -> bool:
    """True if the other robot's part cannot have come before what began then.

    :param is_told: the other robot has said that it had ended its part, so that its report may still be on its way.
    """
    known = parts.get((ordering.before, other), {})
    is_open = is_told and known.get("state") not in (PacketState.FINISHED, PacketState.FAILED)
    if is_open or ordering.kept_by is Keeping.SENSING or known.get("implied", False):
        least_s = _least_begin_s(net, ordering.before, other, parts)
        return least_s is not None and least_s - begun_s > CLOCKS_S
    if known.get("state") != PacketState.FINISHED:
        return True
    return bool(known["finished_at_s"] - begun_s > CLOCKS_S)


def _least_begin_s(net: PlanNet, action: str, robot: str, parts: Parts) -> float | None:
    """A time before which the robot has not begun its part, by its own reports; None if they say nothing of that."""
    begun_s: float | None = parts.get((action, robot), {}).get("started_at_s")
    if begun_s is not None:
        return begun_s
    before = net.of_robot(robot)
    earlier = before[: [one.id for one in before].index(action)]
    known = [parts[one.id, robot] for one in earlier if (one.id, robot) in parts]
    return max((one["at_s"] for one in known if "at_s" in one and not one.get("implied")), default=None)


def _handed_over(net: PlanNet, ordering: Ordering) -> tuple[str, ...]:
    links = (
        link.fact
        for link in net.causal_links
        if (link.producer, link.consumer) == (ordering.before, ordering.after)
    )
    return tuple(sorted({fact.args[0] for fact in links if fact.predicate == OBJECT_POSITION}))
