"""The process of the 3D view: started when a page first asks for it, ended by itself when nobody looks."""

import os
import secrets
import socket
import subprocess
import sys
import threading
from collections.abc import Sequence

from app.domain.clock import SYSTEM_CLOCK, WallClock

RESTART_S = 5.0
"""Least time between two starts: a view that fails at once must not be started again by each request."""
STOP_TIMEOUT_S = 5.0


class ViewProcess:
    """A client of the API in a process of its own; ends with the service at the latest. Thread-safe."""

    def __init__(self, clock: WallClock = SYSTEM_CLOCK) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._command: Sequence[str] = ()
        self._token = ""
        self._port = 0
        self._secret = secrets.token_urlsafe(32)
        self._start_at_s = 0.0

    def allow(self, *, api: str, token: str) -> None:
        """From now on it is started when it is asked for."""
        # -P: a folder "web" in the working directory must not shadow the package
        module = ["-P", "-m", "web.viewer"]
        with self._lock:
            self._command = [sys.executable, *module, "--api", api, "--parent", str(os.getpid())]
            self._token = token

    def address(self) -> str | None:
        """Its address with the secret, which only the two processes have; None while it may not be started.

        If it is not running it is started, and accepts connections a little later.
        """
        with self._lock:
            if not self._is_running and self._command and self._clock.monotonic_s() >= self._start_at_s:
                self._start_at_s = self._clock.monotonic_s() + RESTART_S
                self._start()
            return f"http://relay:{self._secret}@127.0.0.1:{self._port}" if self._is_running else None

    @property
    def _is_running(self) -> bool:
        return self._process is not None and self._process.poll() is None

    def _start(self) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self._port = free.getsockname()[1]
        self._process = subprocess.Popen(
            [*self._command, "--port", str(self._port)],
            env={**os.environ, "MACTA_TOKEN": self._token, "MACTA_VIEWER_SECRET": self._secret},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            start_new_session=True,
        )

    def reap(self) -> None:
        """Take note of its end, if it has ended: nothing is left of it in the table of processes."""
        with self._lock:
            if self._process is not None:
                self._process.poll()

    def stop(self) -> None:
        """End it; it is not started again."""
        with self._lock:
            self._command = ()
            process = self._process
        if process is None:
            return
        process.terminate()
        try:
            process.wait(timeout=STOP_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
