"""What a client did that cannot be done, with the way out. `app.api.problems` turns these into HTTP problems."""

from collections.abc import Sequence


class MactaError(Exception):
    """Root of the service's errors. `code` is stable, `detail` is for people, `choices` are what would work."""

    code = "error"
    retry_after_s: float | None = None
    """When to ask again, where that helps."""

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


def unrecorded(what: str, name: str) -> NotFound:
    """A goal, plan or mission that the record does not know, or not any more."""
    reason = "there was none, or it was over long ago and is deleted (MACTA_KEEP_GOALS_DAYS)"
    return NotFound(f"no {what} {name!r}: {reason}", code=f"unknown-{what}")


class Conflict(MactaError):
    """Raised when a request contradicts the present state of things."""

    code = "conflict"


class Outdated(Conflict):
    """Raised when a change was made from a version of things that is no longer the newest."""

    code = "outdated"


class Unavailable(MactaError):
    """Raised when the service cannot take a request now but will later."""

    code = "unavailable"
    retry_after_s = 5.0


class Busy(MactaError):
    """Raised when there is no room for one more of its kind until some of them have ended."""

    code = "busy"
    retry_after_s = 10.0


class Silent(MactaError):
    """Raised when a robot that was asked does not answer in time."""

    code = "robot-silent"


class IllegalTransition(Exception):
    """Raised when code would change a state as its life cycle does not allow: a defect, not a client's mistake."""
