"""Decorators of functions that numba compiles at their first call.

numba takes half a second and 50 MB to import, and most processes that import these modules call no such function: so it
is imported at the first call of one. The machine code is cached as `robots.kernels` describes. Where nothing is
compiled (`robots.kernels.compiles`) the functions run as Python, and numba is not imported.
"""

from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any, Generic, ParamSpec, TypeVar

from robots.kernels import compiles

P = ParamSpec("P")
R = TypeVar("R")

_PARTS: list[Callable[..., Any]] = []
"""Functions that compiled ones may call and that are not yet known to numba."""


class Kernel(Generic[P, R]):
    """A function, compiled at its first call; other kernels may call it."""

    def __init__(self, function: Callable[P, R]) -> None:
        update_wrapper(self, function)
        self.function = function

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        result: R = self.dispatcher(*args, **kwargs)
        return result

    @cached_property
    def dispatcher(self) -> Any:
        """numba's counterpart of the function, or the function itself if nothing is to be compiled."""
        if not compiles():
            return self.function
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
