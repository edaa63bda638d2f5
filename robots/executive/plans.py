"""A behaviour script as a plan of actuator actions: each packet waits, acts, and may have to retry."""

from collections.abc import Sequence
from enum import StrEnum

from robots.conditions.facts import REPORTED
from robots.executive.actions import ActuatorAction, TaskPlan, percepts_of, superseded
from robots.perception.percepts import NOTHING, Needs
from robots.reactive.stall import BACKS_OFF, WATCHED
from robots.repertoire import BoundPacket
from robots.wire import BehaviourPacket, BehaviourScript


class Phase(StrEnum):
    """What a packet is at: for its pre-conditions, for its post-conditions, or for a free way."""

    WAIT = "wait"
    ACT = "act"
    RETRY = "retry"


def name_of(packet: BehaviourPacket, phase: Phase) -> str:
    return f"{packet.id}/{phase}"


def task_plan(script: BehaviourScript, contents: Sequence[BoundPacket]) -> TaskPlan:
    """⟨t, c, bd⟩ of a script: invoked by its request, applicable where its first packet is, its packets in order."""
    pairs = list(zip(script.packets, contents, strict=True))
    return TaskPlan(
        invocation=script.id,
        context=contents[0].before,
        body=tuple(action for packet, content in pairs for action in _in_order(packet, content)),
        recoveries={
            name_of(packet, Phase.ACT): ActuatorAction(
                name=name_of(packet, Phase.RETRY), percepts=_acting(content) | BACKS_OFF
            )
            for packet, content in pairs
        },
    )


def _in_order(packet: BehaviourPacket, content: BoundPacket) -> tuple[ActuatorAction, ActuatorAction]:
    wait = ActuatorAction(
        name=name_of(packet, Phase.WAIT), percepts=REPORTED | percepts_of(content.before, content.waiting)
    )
    act = ActuatorAction(
        name=name_of(packet, Phase.ACT),
        percepts=_acting(content),
        pre=content.before,
        add=frozenset(packet.achieves),
        delete=superseded(packet.requires, packet.achieves),
    )
    return wait, act


def _acting(content: BoundPacket) -> Needs:
    conditions = [*content.maintain, *content.after]
    conditions += [condition for event in content.events.values() for condition in event]
    avoiding = NOTHING if content.avoid is None else content.avoid.needs
    return REPORTED | WATCHED | avoiding | percepts_of(conditions, content.patterns)
