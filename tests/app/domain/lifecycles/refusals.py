"""Whether a command is refused."""

from collections.abc import Callable


def refused(command: Callable[[], None], error: type[Exception]) -> bool:
    try:
        command()
    except error:
        return True
    return False
