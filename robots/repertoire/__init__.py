"""A robot's behavioural repertoire: the content of its packets, as data, and how a packet on the wire becomes
one.

Only on-robot software looks in here: the reflective agent knows packets by tag (MACTA §4).
"""

from robots.repertoire.load import Repertoire, load_repertoire
from robots.repertoire.schema import BoundPacket, PacketSpec
from robots.repertoire.tuning import Tuning

__all__ = ["BoundPacket", "PacketSpec", "Repertoire", "Tuning", "load_repertoire"]
