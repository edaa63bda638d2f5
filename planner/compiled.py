"""Decorators of compiled functions (numba), and numba's private option `_nrt`.

The machine code is cached where numba is told to; see `robots.kernels`, which entry points call.
"""

from typing import Any

import numba

_LEAN: dict[str, Any] = {"_nrt": False, "error_model": "numpy"}
"""Without numba's runtime for reference-counted objects. Private: `tests/planner/test_compiled.py` is
its contract test."""

kernel = numba.njit(cache=True)
"""Compiles a function on its first call and keeps its machine code."""
lean = numba.njit(cache=True, **_LEAN)
"""Likewise, for functions that create no arrays: three times as fast without reference counting."""
inlined = numba.njit(cache=True, inline="always", **_LEAN)
"""Likewise, inlined into the caller: passing the model would cost more than most of these functions do."""
