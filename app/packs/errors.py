"""The error of domain packs."""

from app.domain.errors import MactaError


class PackError(MactaError):
    """Raised when a domain pack is missing or not valid; names the pack or file, the line, the slot and the choices."""

    code = "pack"
