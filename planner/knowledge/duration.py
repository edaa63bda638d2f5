"""Learned durations: what experience multiplies an action's duration by."""

DURATION_SCALE = "duration_scale"
"""A function every knowledge base has: by action and team size, what its durations are multiplied by."""


def scale_term(action: str, team: int) -> tuple[str, tuple[str, ...]]:
    """The function term of the factor for an action done by `team` robots; without a value it is 1."""
    return DURATION_SCALE, (action, str(team))
