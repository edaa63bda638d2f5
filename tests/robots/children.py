"""What child processes of tests do, and a module that they may share."""

import os
import signal
import sys
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

SHARED = "tests.robots.physical"
"""A module that nothing here imports, and that takes little to import."""


def tell(pipe: "Connection[dict[str, Any], None]", variable: str) -> None:
    """Say what one is, by the other end of a pipe."""
    pipe.send(
        {
            "parent": os.getppid(),
            "name": Path("/proc/self/comm").read_text().strip(),
            "variable": os.environ.get(variable),
            "blocks_interrupts": signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []),
            "has_shared": SHARED in sys.modules,
        }
    )
