"""Legs of a plan as contents of a contract net: what is called for, a bid, an award.

leg(LEG, packet(TAG, 30, object(sample_1), ref1(bay_1), ref2(hatch)), ...)    cfp: work in seconds, parameters
bid(LEG, cost(75), release(20), way(25), work(30), battery(0.8), degraded("whisker 3"))    propose
declined(LEG, battery, "battery at 9% after it")    refuse
award(LEG, SCRIPT)    accept-proposal, with the script by which the robot is to do it
reject(LEG)    reject-proposal
done(LEG), failed(LEG, "reason")    inform, failure
done(LEG, near(PLACE)), failed(LEG, "reason", ended(2), held(sample_1))    likewise, to a robot whose leg it is: where
    the other stands now; how many packets have ended, left out if that is not known, and what it holds
"""

from collections.abc import Sequence
from dataclasses import dataclass

from robots.executive.offer import Declined, Declining, Offer
from robots.social.terms import Argument, ContentError, Term
from robots.wire import BehaviourPacket, BehaviourScript

LEG = "leg"
AWARD = "award"
REJECT = "reject"
CALLED_FOR = "called_for"
"""The mission of a leg that is only called for."""
LONGEST_PACKET_S = 24 * 3600.0
MOST_PACKETS = 64
MOST = MOST_PACKETS * LONGEST_PACKET_S
"""The greatest figure of a bid or a failure: no leg takes longer."""


def call_of(leg: str, packets: Sequence[BehaviourPacket]) -> Term:
    """The content of a call for proposals."""
    return Term(LEG, (leg, *(_packet_term(packet) for packet in packets)))


def leg_of(call: Term, robot: str) -> BehaviourScript:
    """A called leg as the script that the robot would get.

    :raises ContentError: naming the part that is none of a leg.
    """
    if not 2 <= len(call.args) <= MOST_PACKETS + 1:
        raise ContentError(
            f"leg(NAME, packet(...), ...) has a name and 1 to {MOST_PACKETS} packets: {call.name}/{len(call.args)}"
        )
    name, *packets = call.args
    return BehaviourScript(
        id=word(name),
        mission_id=CALLED_FOR,
        robot=robot,
        packets=tuple(_packet(one, str(at)) for at, one in enumerate(packets)),
    )


def bid_of(leg: str, made: Offer | Declined) -> Term:
    """The content of a proposal or a refusal."""
    if isinstance(made, Declined):
        return Term("declined", (leg, made.reason.value, made.words))
    figures = {
        "cost": made.cost_s,
        "release": made.release_s,
        "way": made.way_s,
        "work": made.work_s,
        "battery": made.battery,
    }
    parts = [Term(name, (round(value, 3),)) for name, value in figures.items()]
    degraded = [Term("degraded", (sensor,)) for sensor in made.degraded]
    return Term("bid", (leg, *parts, *degraded))


def declining_of(refusal: Term) -> Declining | None:
    """The kind of reason that a refusal states; None if it states none that is known."""
    kinds = {kind.value: kind for kind in Declining}
    return kinds.get(refusal.words[1]) if len(refusal.args) > 1 else None


def offer_of(bid: Term) -> Offer:
    """The offer that a bid states.

    :raises ContentError: if it lacks a figure, or one is negative or beyond `MOST`.
    """
    parts = [one for one in bid.args[1:] if isinstance(one, Term)]
    figures = {one.name: one.args[0] for one in parts if len(one.args) == 1}

    def figure(name: str) -> float:
        value = figures.get(name)
        if not isinstance(value, float):
            raise ContentError(f"{bid} has no {name}(NUMBER)")
        return _counted(value, bid)

    return Offer(
        cost_s=figure("cost"),
        release_s=figure("release"),
        way_s=figure("way"),
        work_s=figure("work"),
        battery=figure("battery"),
        degraded=tuple(one.words[0] for one in parts if one.name == "degraded" and len(one.args) == 1),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Failed:
    """How a leg has failed.

    :param ended: how many of its packets had ended; None if that is not known.
    :param held: what the robot holds.
    """

    reason: str
    ended: int | None = None
    held: str | None = None


def failed_of(leg: str, failed: Failed) -> Term:
    """The content of the failure of a leg that a robot has awarded."""
    ended = () if failed.ended is None else (Term("ended", (float(failed.ended),)),)
    held = () if failed.held is None else (Term("held", (failed.held,)),)
    return Term("failed", (leg, failed.reason, *ended, *held))


def failure_of(content: Term) -> Failed:
    """What the content of a failure states; what it leaves out is not known.

    :raises ContentError: if what it states is no number of packets, or no name.
    """
    parts = {one.name: one.args for one in content.args if isinstance(one, Term) and len(one.args) == 1}
    (ended,) = parts.get("ended", (None,))
    (held,) = parts.get("held", (None,))
    return Failed(
        reason=content.words[1] if len(content.args) > 1 else "",
        ended=int(_counted(ended, content)) if isinstance(ended, float) else None,
        held=None if held is None else word(held),
    )


def word(argument: Argument) -> str:
    """A name as text.

    :raises ContentError: if it is a number or has arguments.
    """
    if isinstance(argument, float) or (isinstance(argument, Term) and argument.args):
        raise ContentError(f"{argument} is no name")
    return argument.name if isinstance(argument, Term) else argument


def _counted(figure: float, content: Term) -> float:
    if not 0 <= figure <= MOST:
        raise ContentError(f"{content}: {figure} is not from 0 to {MOST:.0f}")
    return figure


def _packet_term(packet: BehaviourPacket) -> Term:
    arguments = [Term(name, (value,)) for name, value in packet.arguments.items()]
    return Term("packet", (packet.tag, float(packet.expected_duration_s), *arguments))


def _packet(part: Argument, packet_id: str) -> BehaviourPacket:
    if not isinstance(part, Term) or part.name != "packet" or len(part.args) < 2:
        raise ContentError(f"{part} is no packet(TAG, SECONDS, PARAMETER(NAME), ...)")
    tag, work_s, *parameters = part.args
    if not isinstance(work_s, float) or not 0 < work_s <= LONGEST_PACKET_S:
        raise ContentError(f"{part}: {work_s} are no seconds of work, up to {LONGEST_PACKET_S:.0f}")
    arguments: dict[str, str] = {}
    for one in parameters:
        if not isinstance(one, Term) or len(one.args) != 1:
            raise ContentError(f"{part}: {one} is no PARAMETER(NAME)")
        arguments[one.name] = word(one.args[0])
    return BehaviourPacket(
        id=packet_id,
        tag=word(tag),
        arguments=arguments,
        expected_start_s=0.0,
        expected_duration_s=work_s,
        timeout_s=work_s,
        wait_timeout_s=work_s,
    )
