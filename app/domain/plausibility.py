"""Whether a robot's report is plausible: in time, in order and in place. Pure.

An implausible report is neither recorded nor receipted, so the robot repeats it. Time and the robot's next telemetry
only make a true report more plausible: it may be recorded late, but it is recorded.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import dist

from app.domain.contradictions import HELD_S, Told
from robots.wire import PacketState, Telemetry

LEAST_SHARE = 0.25
"""The least share of its expected duration that a packet takes (our choice)."""
ROUNDING_S = 1e-6
"""Sums of times in different orders differ by less."""
AHEAD_S = 5.0
"""World seconds by which a report may be ahead of the world's clock as read by the service (our choice)."""
OUT_OF_ORDER_S = 60.0
"""World seconds by which a robot's reports may contradict their order: one that resumes from its snapshot repeats some
of its work (our choice)."""
PLACE_M = 2.5
"""Greatest distance between a place and the reported position of a robot at or near it (our choice)."""
SIGHT_M = 4.0
"""Likewise of a robot that sees what lies in the place: robots rely on their sight up to 3 m."""
SPEED_FACTOR = 1.5
"""A robot may be faster than its stated greatest speed by this factor (our choice)."""

Point = tuple[float, float]
Packets = Mapping[str, Mapping[str, object]]
"""By packet id its recorded state, `at_s` and `finished_at_s`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Presence:
    """A robot's reported position.

    :param speed_m_s: its greatest speed.
    """

    telemetry: Telemetry
    speed_m_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Work:
    """A script and what is recorded of its execution.

    :param ids: of its packets, in order.
    :param tags: of these packets.
    :param expected_s: their expected durations.
    :param firsts: for each the index of the first packet that is a phase of the same action; its own if there are none.
    :param known: what was recorded of them.
    :param given_at_s: when it was given to the robot (world's clock), None if that is not known.
    """

    script_id: str
    ids: Sequence[str]
    tags: Sequence[str]
    expected_s: Sequence[float]
    firsts: Sequence[int]
    known: Packets
    given_at_s: float | None


def doubt_of_time(at_s: float, *, now_s: float, lag_s: float) -> str:
    """Why a report cannot have been made at its stated time; empty if it can.

    :param lag_s: by how much the world's clock may be ahead of `now_s`.
    """
    ahead_s = at_s - now_s
    if ahead_s <= AHEAD_S * (1.0 + lag_s):
        return ""
    return f"sent a report dated {ahead_s:.0f} s in the future"


def doubt_of_finish(work: Work, packet: str, at_s: float, *, now_s: float, lag_s: float) -> str:
    """Why a packet, and with it those before it, cannot have finished; empty if they can.

    :param at_s: when it finished, as reported.
    """
    index = work.ids.index(packet)
    what = f"reports that {work.tags[index]} has finished"
    for other, name in enumerate(work.ids):
        said_s = _number(work.known, name, "at_s")
        if said_s is None:
            continue
        is_out_of_order = said_s > at_s + OUT_OF_ORDER_S if other < index else said_s < at_s - OUT_OF_ORDER_S
        if other != index and is_out_of_order:
            order = "before" if other < index else "after"
            return f"{what} at {at_s:.0f} s, but reported {work.tags[other]} {order} it at {said_s:.0f} s"
        if other < index and work.known[name].get("state") == PacketState.FAILED:
            return f"{what}, but {work.tags[other]} before it has failed"
    if _finished(work.known, packet):
        return ""
    # All packets before a finished one have finished, even if their own reports are lost. Of an action's phases only
    # all together take their time: where one ends and the next begins depends on where exactly the robot stood.
    first = work.firsts[index]
    goes_on = first in work.firsts[index + 1 :]
    done = next((i for i in range(first - 1, -1, -1) if _finished(work.known, work.ids[i])), -1)
    ended_s = _number(work.known, work.ids[done], "finished_at_s") if done >= 0 else None
    since_s = max((one for one in (work.given_at_s, ended_s) if one is not None), default=None)
    if since_s is None:
        return ""
    least_s = LEAST_SHARE * sum(work.expected_s[done + 1 : first if goes_on else index + 1])
    took_s = min(max(now_s, at_s), now_s + lag_s) - since_s
    if took_s >= least_s - ROUNDING_S:
        return ""
    return f"{what} after {max(took_s, 0.0):.1f} s, which takes {least_s:.1f} s at least"


def doubt_of_order(begun: Told, awaited: Sequence[Told], *, at_s: float, now_s: float) -> str:
    """Why a packet cannot have begun yet, whose robot waits for another's; empty once the other's report is overdue.

    :param awaited: what the robots of the action that it waits for have reported of it.
    :param at_s: when it began, as reported.
    """
    if now_s - at_s >= HELD_S:
        return ""
    said = " and ".join(map(str, awaited))
    return f"reports {begun.packet} {begun.tag} at {at_s:.1f} s without clearance, but {said}"


def doubt_of_progress(work: Work, packet: str, at_s: float, telemetry: Telemetry) -> str:
    """Why a packet cannot have finished according to the robot's later telemetry; empty if it can."""
    is_later = telemetry.at_s > at_s and telemetry.script_id == work.script_id
    if not is_later or telemetry.packet_id not in work.ids:
        return ""
    index = work.ids.index(packet)
    under_way = work.ids.index(telemetry.packet_id)
    if under_way > index or telemetry.packet_state is PacketState.FINISHED:
        return ""
    return (
        f"reports that {work.tags[index]} has finished, but its telemetry still shows {work.tags[under_way]}"
    )


def doubt_of_place(place: str, point: Point, at_s: float, presence: Presence, *, within_m: float) -> str:
    """Why the robot cannot have been at or near a place; empty if it can.

    :param within_m: how far from it the robot may have been.
    """
    here = presence.telemetry
    away_m = dist(point, (here.x_m, here.y_m))
    reach_m = within_m + SPEED_FACTOR * presence.speed_m_s * abs(here.at_s - at_s)
    if away_m <= reach_m:
        return ""
    return f"reports to be at {place}, but its telemetry shows it {away_m:.1f} m away"


def _finished(known: Packets, name: str) -> bool:
    return known.get(name, {}).get("state") == PacketState.FINISHED


def _number(known: Packets, name: str, key: str) -> float | None:
    value = known.get(name, {}).get(key)
    return float(value) if isinstance(value, int | float) else None
