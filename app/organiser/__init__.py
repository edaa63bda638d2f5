"""The mission organiser (MACTA §4, fig. 4): behaviours library, scripts for robots, estimated time. Pure."""

from app.organiser.estimate import Margin
from app.organiser.library import Library, LibraryError, load_library
from app.organiser.organise import Organised, OrganiserFailure, organise

__all__ = [
    "Library",
    "LibraryError",
    "Margin",
    "Organised",
    "OrganiserFailure",
    "load_library",
    "organise",
]
