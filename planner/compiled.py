"""Decorators of compiled functions (numba), and numba's private option `_nrt`.

The machine code is cached where numba is told to; see `robots.kernels`, which entry points call.
"""

import os
from collections.abc import Callable
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

_LEAN: dict[str, Any] = {"_nrt": False, "error_model": "numpy"}
"""Without numba's runtime for reference-counted objects. Private: `tests/planner/test_compiled.py` is
its contract test."""


def _not_compiled(**_: Any) -> Callable[[Function], Function]:
    return lambda function: function


_compile: Any
if os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0"):
    import numba

    _compile = numba.njit
else:  # numba's own switch: the functions run as Python, and numba is not imported
    _compile = _not_compiled

kernel = _compile(cache=True)
"""Compiles a function on its first call and keeps its machine code."""
lean = _compile(cache=True, **_LEAN)
"""Likewise, for functions that create no arrays: three times as fast without reference counting."""
inlined = _compile(cache=True, inline="always", **_LEAN)
"""Likewise, inlined into the caller: passing the model would cost more than most of these functions do."""
