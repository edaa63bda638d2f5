"""Which packets a robot takes: their tags and arguments, checked before a script is accepted."""

from collections.abc import Mapping, Set
from dataclasses import dataclass

from robots.wire import BehaviourPacket, BehaviourScript


@dataclass(frozen=True, slots=True, kw_only=True)
class PacketForm:
    """The form of the packets of one tag.

    `arguments` must be given; more may be, because a packet has all those of its plan-net action. `choices`: the values
    that an argument may have, such as the places that the robot knows; without an entry, any.
    """

    arguments: tuple[str, ...] = ()
    choices: Mapping[str, Set[str]] | None = None


def why_refused(
    script: BehaviourScript, robot: str, forms: Mapping[str, PacketForm], senses: Set[str]
) -> str | None:
    """Why the robot cannot carry the script out, in words; None if it can.

    :param forms: by the tags of the packets that the robot has.
    :param senses: the predicates that it can sense.
    """
    if script.robot != robot:
        return f"script {script.id} is for {script.robot}, this is {robot}"
    ids = [packet.id for packet in script.packets]
    if len(set(ids)) < len(ids):
        twice = next(one for one in ids if ids.count(one) > 1)
        return f"script {script.id} has two packets {twice}"
    reasons = (_why_unfit(packet, robot, forms, senses) for packet in script.packets)
    return next((reason for reason in reasons if reason is not None), None)


def _why_unfit(
    packet: BehaviourPacket, robot: str, forms: Mapping[str, PacketForm], senses: Set[str]
) -> str | None:
    form = forms.get(packet.tag)
    if form is None:
        known = ", ".join(sorted(forms)) or "none"
        return f"{packet.tag} is not in the repertoire of {robot}; it has: {known}"
    missing = [name for name in form.arguments if name not in packet.arguments]
    if missing:
        return f"{packet.tag} lacks the argument {', '.join(missing)}"
    for name, choices in (form.choices or {}).items():
        value = packet.arguments.get(name)
        if value is not None and value not in choices:
            known = ", ".join(sorted(choices)) or "none"
            return f"{packet.tag}: {name} = {value} is not known to {robot}; known: {known}"
    unsensed = [fact for fact in packet.awaits if fact.predicate not in senses]
    if unsensed:
        return (
            f"{robot} cannot sense {unsensed[0]}, which {packet.tag} ({packet.id}) awaits; "
            f"it senses: {', '.join(sorted(senses)) or 'nothing'}"
        )
    return None
