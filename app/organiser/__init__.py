"""The mission organiser (MACTA §4, fig. 4): behaviours library, scripts for robots, estimated time. Pure."""

from app.organiser.estimate import Margin, enquiry_at_s, estimate_s
from app.organiser.library import Library, LibraryError, load_library
from app.organiser.organise import Organised, OrganiserFailure, organise

__all__ = [
    "Library",
    "LibraryError",
    "Margin",
    "Organised",
    "OrganiserFailure",
    "enquiry_at_s",
    "estimate_s",
    "load_library",
    "organise",
]
