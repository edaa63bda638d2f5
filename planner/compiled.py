"""Compiled functions and where their machine code is kept.

numba notices a change of a function's own file only, not of the functions it calls. So the code is kept in a folder
named after the content of all the files concerned: a changed kernel is compiled anew (seconds, once).
"""

import hashlib
import os
import tempfile
from pathlib import Path
from typing import Any

import numba

SCHEDULING = "engines/hierarchical/scheduling"
KERNEL = (
    "compiled.py",
    f"{SCHEDULING}/model.py",
    f"{SCHEDULING}/decoder_state.py",
    f"{SCHEDULING}/placement.py",
    f"{SCHEDULING}/decoder.py",
    f"{SCHEDULING}/annealing.py",
)


def _cache_folder() -> Path:
    """A folder that can be written, the user's cache before the temporary one."""
    here = Path(__file__).parent
    sources = hashlib.sha256(b"".join((here / name).read_bytes() for name in KERNEL)).hexdigest()[:16]
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    for base in (home, Path(tempfile.gettempdir()) / f"macta-{os.getuid()}"):
        folder = base / "macta" / f"planner-{sources}"
        try:
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    return Path(tempfile.mkdtemp(prefix="macta-planner-"))


setattr(numba.config, "CACHE_DIR", str(_cache_folder()))  # noqa: B010, mypy does not know it

_LEAN: dict[str, Any] = {"_nrt": False, "error_model": "numpy"}  # numba's stubs do not know the first

kernel = numba.njit(cache=True)
"""Compiles a function on its first call and keeps its machine code."""
lean = numba.njit(cache=True, **_LEAN)
"""Likewise, of functions that make no arrays: three times as quick, as none need be counted for its release."""
inlined = numba.njit(cache=True, inline="always", **_LEAN)
"""Likewise, as part of the caller: handing on the model would cost more than most of them do."""
