"""What a client did that cannot be done, with the way out. `app.api.problems` turns these into HTTP problems."""

from collections.abc import Sequence


class MactaError(Exception):
    """Root of the service's errors. `code` is stable, `detail` is for people, `choices` are what would work."""

    code = "error"

    def __init__(self, detail: str, *, code: str | None = None, choices: Sequence[str] = ()) -> None:
        super().__init__(detail)
        self.detail = detail
        self.code = code or type(self).code
        self.choices = tuple(choices)


class Invalid(MactaError):
    """Raised when a request can never be carried out as it is."""

    code = "invalid"


class NotFound(MactaError):
    """Raised when a request names a thing that does not exist."""

    code = "not-found"


class Conflict(MactaError):
    """Raised when a request contradicts the present state of things."""

    code = "conflict"


class Outdated(Conflict):
    """Raised when a change was made from a version of things that is no longer the newest."""

    code = "outdated"


class Unavailable(MactaError):
    """Raised when the service cannot take a request now but will later."""

    code = "unavailable"


class Silent(MactaError):
    """Raised when a robot that was asked does not answer in time."""

    code = "robot-silent"
