"""The mission organiser (MACTA §4, fig. 4): behaviours library, scripts for robots, estimated time. Pure."""

from app.domain.mission_organiser.behaviours_library import (
    Library,
    LibraryError,
    load_library,
    shipped_library,
)
from app.domain.mission_organiser.estimate import Margin
from app.domain.mission_organiser.organise import Organised, OrganiserFailure, organise

__all__ = [
    "Library",
    "LibraryError",
    "Margin",
    "Organised",
    "OrganiserFailure",
    "load_library",
    "organise",
    "shipped_library",
]
