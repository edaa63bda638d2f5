"""Ports of loopback for the servers of tests."""

import os
import socket
from itertools import count

FIRST, PER_WORKER, WORKERS = 20_000, 1_500, 8
"""Below the ports that the kernel gives to clients, so that no outgoing connection takes one between two uses."""
_WORKER = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")) % WORKERS
_counted = count(os.getpid() % PER_WORKER)


def free_port() -> int:
    """One of loopback's that nobody listens on, and that no test of this process had lately.

    A client of an ended test that still tries to reconnect would otherwise meet the server of another.
    """
    for number in _counted:
        port = FIRST + _WORKER * PER_WORKER + number % PER_WORKER
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            if _is_free(probe, port):
                return port
    raise AssertionError("counting never ends")


def _is_free(probe: socket.socket, port: int) -> bool:
    try:
        probe.bind(("127.0.0.1", port))
    except OSError:
        return False
    return True
