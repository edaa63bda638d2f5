"""A robot's behavioural repertoire: the contents of its packets, as data, and binding packets of the wire to them.

For on-robot software only: the reflective agent knows packets by tag (MACTA §4).
"""

from robots.repertoire.load import Repertoire, load_repertoire, read_packet, read_repertoire, store_packets
from robots.repertoire.schema import BoundPacket, PacketSpec
from robots.repertoire.self_level import SelfLevel, load_self_level
from robots.repertoire.sensed_facts import SensedFact, SensedFacts
from robots.repertoire.tuning import Tuning, parameters

__all__ = [
    "BoundPacket",
    "PacketSpec",
    "Repertoire",
    "SelfLevel",
    "SensedFact",
    "SensedFacts",
    "Tuning",
    "load_repertoire",
    "load_self_level",
    "parameters",
    "read_packet",
    "read_repertoire",
    "store_packets",
]
