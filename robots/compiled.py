"""Decorators of functions that numba compiles at their first call.

numba takes half a second and 50 MB to import, and most processes that import these modules call no such function: so it
is imported at the first call of one. The machine code is cached as `robots.kernels` describes. Where nothing is
compiled (`robots.compilation.compiles`) the functions run as Python, and numba is not imported.
"""

import os
import threading
from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any, Generic, ParamSpec, TypeVar

from robots.compilation import (
    DISABLED,
    IN_BACKGROUND,
    Group,
    compile_once,
    compiles,
    is_compiled,
    run_uncompiled,
)

P = ParamSpec("P")
R = TypeVar("R")

POLL_S = 0.5
"""Interval of a process's checks whether another has compiled what it runs as Python."""

_PARTS: list[Callable[..., Any]] = []
"""Functions that compiled ones may call and that are not yet known to numba."""
KERNELS: list["Kernel[..., Any]"] = []
"""All kernels of the modules that are imported."""


class Kernel(Generic[P, R]):
    """A function, compiled at its first call; other kernels may call it."""

    def __init__(self, function: Callable[P, R]) -> None:
        update_wrapper(self, function)
        self.function = function
        self.choose_at_next_call()
        KERNELS.append(self)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        return self._run(*args, **kwargs)

    def choose_at_next_call(self) -> None:
        """Decide at the next call whether the function is compiled."""
        self._run: Callable[P, R] = self._choose

    def _choose(self, *args: P.args, **kwargs: P.kwargs) -> R:
        self._run = self.dispatcher if compiles() else self.function
        return self._run(*args, **kwargs)

    @cached_property
    def dispatcher(self) -> Any:
        """numba's counterpart of the function."""
        import numba

        _introduce()
        return numba.njit(cache=True)(self.function)


def kernel(function: Callable[P, R]) -> Kernel[P, R]:
    """Compile the function at its first call and keep its machine code."""
    return Kernel(function)


def part(function: Callable[P, R]) -> Callable[P, R]:
    """Let kernels call the function, which stays as it is elsewhere."""
    _PARTS.append(function)
    return function


def get_compiled(group: Group, tell: Callable[[str], None]) -> None:
    """Have the group's functions compiled before any of them is called.

    If another process compiles them in the background, they run as Python until their machine code is cached.

    :param tell: called with what is being done, if that takes time.
    """
    if not compiles() or is_compiled(group):
        return
    if IN_BACKGROUND in os.environ:
        run_uncompiled()
        threading.Thread(target=_change_over, args=(group,), name="change-over", daemon=True).start()
    else:
        compile_once(group, tell)


def _change_over(group: Group) -> None:
    """Wait for the group's machine code, and have the kernels use it from then on."""
    never = threading.Event()
    while not is_compiled(group):
        never.wait(POLL_S)
    use_compiled()


def use_compiled() -> None:
    """Have functions that ran as Python use their machine code from now on."""
    os.environ.pop(DISABLED, None)
    import numba  # noqa: F401, here, so that no kernel's next call has to wait for it

    for one in KERNELS:
        one.choose_at_next_call()


def _introduce() -> None:
    """Register the parts, and the type of kernels, with numba."""
    from numba import types
    from numba.extending import register_jitable, typeof_impl

    while _PARTS:
        register_jitable(_PARTS.pop())
    if Kernel not in typeof_impl.registry:

        @typeof_impl.register(Kernel)
        def _type_of(value: Kernel[..., Any], _: Any) -> Any:
            return types.Dispatcher(value.dispatcher)
