"""A robot's behavioural repertoire: the content of its packets, as data, and how a packet on the wire becomes
one.

Only on-robot software looks in here: the reflective agent knows packets by tag (MACTA §4).
"""

from robots.repertoire.load import Repertoire, load_repertoire
from robots.repertoire.schema import BoundPacket, PacketSpec
from robots.repertoire.self_level import SelfLevel, load_self_level
from robots.repertoire.tuning import Tuning, parameters

__all__ = [
    "BoundPacket",
    "PacketSpec",
    "Repertoire",
    "SelfLevel",
    "Tuning",
    "load_repertoire",
    "load_self_level",
    "parameters",
]
