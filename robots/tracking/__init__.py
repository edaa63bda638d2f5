"""Object tracking (SRA): what several sensors tell of things becomes cursors, whose evidence grows and decays.

`recognition` makes observations of what sensors read, `tracker` fuses them, `cursor` is what behaviours and conditions
go by. On-robot software only.
"""

from robots.tracking.cursor import Cursor, Cursors
from robots.tracking.observation import Modality, Observation
from robots.tracking.tracker import ObjectTracking

__all__ = ["Cursor", "Cursors", "Modality", "ObjectTracking", "Observation"]
