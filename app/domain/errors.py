"""The service's errors. `app.api.problems` turns them into HTTP problem documents."""

from collections.abc import Iterable, Sequence


class MactaError(Exception):
    """Root of the service's errors.

    :param detail: for people.
    :param code: stable, for programs.
    :param choices: values that would have been accepted.
    :param constraints: those that cannot be kept together, in words.
    :param thing: the word or name that it is about.
    :param span: start and end of that word in a sentence.
    """

    code = "error"
    retry_after_s: float | None = None
    """When to repeat the request, if that helps."""

    def __init__(
        self,
        detail: str,
        *,
        code: str | None = None,
        choices: Sequence[str] = (),
        constraints: Sequence[str] = (),
        thing: str = "",
        span: tuple[int, int] | None = None,
    ) -> None:
        super().__init__(detail)
        self.detail = detail
        self.code = code or type(self).code
        self.choices = tuple(choices)
        self.constraints = tuple(constraints)
        self.thing = thing
        self.span = span


class Invalid(MactaError):
    """Raised when a request can never be carried out as it is."""

    code = "invalid"


class NotFound(MactaError):
    """Raised when a request names a thing that does not exist."""

    code = "not-found"


class UnknownWorld(NotFound, KeyError):
    """Raised when a world is looked up that does not run, or does no longer: worlds are removed at any time."""

    def __init__(self, name: str, choices: Iterable[str] = ()) -> None:
        super().__init__(f"unknown world {name!r}", code="unknown-world", choices=sorted(choices), thing=name)


def unrecorded(what: str, name: str) -> NotFound:
    """The error for a goal, plan or mission that does not exist or was deleted."""
    reason = "it never existed, or ended long ago and was deleted (MACTA_KEEP_GOALS_DAYS)"
    return NotFound(f"no {what} {name!r}: {reason}", code=f"unknown-{what}")


class Conflict(MactaError):
    """Raised when a request contradicts the current state."""

    code = "conflict"


class Outdated(Conflict):
    """Raised when a change is based on a version that is no longer the newest."""

    code = "outdated"


class Unavailable(MactaError):
    """Raised when the service cannot accept a request now but will later."""

    code = "unavailable"
    retry_after_s = 5.0


class Busy(MactaError):
    """Raised when a limit on concurrent goals, streams or questions is reached."""

    code = "busy"
    retry_after_s = 10.0


class Silent(MactaError):
    """Raised when a robot that was asked does not answer in time."""

    code = "robot-silent"


class IllegalTransition(Exception):
    """Raised when code attempts a transition that the life cycle does not allow: a defect, not a client's mistake."""
