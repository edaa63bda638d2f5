"""What plans count for waiting is what the sensors draw that run while a packet waits."""

import pytest

from planner import load_knowledge_base
from planner.knowledge import Operator
from planner.knowledge.change import WAITING
from planner.knowledge.expression import Expression
from robots.executive.sensing_plan import Phase, schedule
from robots.physical.energy import load_powers
from robots.repertoire import load_repertoire
from tests.robots.stories import packet, script

BASE = load_knowledge_base()
REPERTOIRE = load_repertoire()
TURNING_W = 0.3
"""At most, on average over a mission, to face what comes next."""
PACKETS = {"CARRY": "TRANSPORT", "CHARGE": "RECHARGE"}
"""By action, if the packet has another name."""


def packet_of(op: Operator) -> str:
    tag = PACKETS.get(op.spec.name, op.spec.name)
    long = f"{tag} (long)"
    return long if "long_object" in op.parameters.values() and long in REPERTOIRE.specs else tag


@pytest.mark.parametrize("name", [op.name for op in BASE.operators if packet_of(op) in REPERTOIRE.specs])
def test_waiting_for_an_action_is_counted_as_what_its_packet_draws_while_it_waits(name: str) -> None:
    (op,) = [op for op in BASE.operators if op.name == name]
    waits = packet(op.spec.name)
    content = REPERTOIRE.specs[packet_of(op)].bind({})
    state = schedule(script("me", waits), [content])[waits.id, Phase.WAIT]
    powers = load_powers()
    drawn_w = powers.electronics_w + powers.sensing_w(state.needs)
    drain = Expression.parse(BASE.quantities["battery"].drain)
    counted_w = drain.value({"robot": "me"}, {("capacity_j", ("me",)): 1.0}, {WAITING: op.waiting})
    assert counted_w is not None
    assert drawn_w <= counted_w <= drawn_w + TURNING_W
