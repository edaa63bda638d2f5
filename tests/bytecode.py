"""Bytecode of the tests' processes: kept between them also where the environment asks for none beside the sources.

The suite starts some hundred interpreters. Without bytecode each of them compiles what it imports, a thousand modules
for a service: five of its eight CPU seconds.
"""

import os
import sys
from pathlib import Path

NOT_WRITTEN = "PYTHONDONTWRITEBYTECODE"
FOLDER = "PYTHONPYCACHEPREFIX"
SWITCH = "MACTA_TESTS_BYTECODE"
"""`off` for who edits sources faster than Python notices: it compares their size, and their time in seconds."""


def keep(folder: Path) -> None:
    """Have this process, and those it starts, write bytecode below this folder, if they would write none.

    Another folder that the environment names stays as it is.
    """
    if sys.dont_write_bytecode and sys.pycache_prefix is None and os.environ.get(SWITCH) != "off":
        os.environ.pop(NOT_WRITTEN, None)
        os.environ[FOLDER] = sys.pycache_prefix = str(folder)
        sys.dont_write_bytecode = False
