"""Effect of idle sockets without a token on a service with a running mission: /healthz, and the size of its log.

uv run python -m benchmarks.idle_sockets [SOCKETS] [SECONDS] [OPEN_FILES]

A process of its own keeps SOCKETS connections open, half of which send half a request; once a second it opens as many
as the service has closed. OPEN_FILES is the service's limit of open files (default: as it is).
"""

import http.client
import multiprocessing
import os
import resource
import selectors
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from urllib.parse import urlsplit

import httpx2

from benchmarks.latency import goal_to_plan_s, until

PAUSE_S = 0.02
TIMEOUT_S = 30.0
HALF_A_REQUEST = b"GET /v1/goals HTTP/1.1\r\nhost:"
SETTLE_S = 3.0
REFILL_S = 1.0


def main(sockets: int = 1000, seconds: int = 60, open_files: int = 0) -> None:
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log"
        limited = ["prlimit", f"--nofile={open_files}:{open_files}"] if open_files else []
        with log.open("wb") as stderr:
            service = subprocess.Popen(
                [*limited, "macta", "serve", "--port", "0", "--data", f"{folder}/data"],
                stdout=subprocess.PIPE,
                stderr=stderr,
                env={**os.environ, "MACTA_TOKEN": "a-token-of-the-benchmark"},
            )
        assert service.stdout is not None
        try:
            said = urlsplit(service.stdout.readline().decode().split(": ", 1)[1].strip())
            address = f"{said.scheme}://{said.netloc}"
            headers = {"authorization": "Bearer a-token-of-the-benchmark"}
            with httpx2.Client(base_url=address, headers=headers, timeout=TIMEOUT_S) as api:
                print(told("alone", health_s(address, seconds / 4)))
                written = log.stat().st_size
                mission = _begin_mission(api)
                stranger = multiprocessing.Process(target=_hold, args=(address, sockets), daemon=True)
                stranger.start()
                time.sleep(SETTLE_S)
                print(told(f"beside {sockets} idle sockets and a mission", health_s(address, seconds)))
                print(f"log: {(log.stat().st_size - written) / 1000:.1f} kB")
                until(lambda: api.get(f"/v1/missions/{mission}").json()["state"] != "running")
                print(f"mission: {api.get(f'/v1/missions/{mission}').json()['state']}")
                stranger.kill()
        finally:
            service.terminate()
            service.wait()


def _begin_mission(api: httpx2.Client) -> str:
    _, plan_id = goal_to_plan_s(api, "move sample_1 to bay_7")
    return str(api.post(f"/v1/plans/{plan_id}:approve").json()["mission_id"])


def health_s(address: str, seconds: float) -> list[float]:
    """Seconds that each answer of /healthz took on a new connection; infinite for one that did not come."""
    took = []
    end = time.perf_counter() + seconds
    while (begun := time.perf_counter()) < end:
        client = http.client.HTTPConnection(urlsplit(address).netloc, timeout=TIMEOUT_S)
        try:
            client.request("GET", "/healthz")
            answered = client.getresponse().status == http.HTTPStatus.OK
        except (OSError, http.client.HTTPException):
            answered = False
        took.append(time.perf_counter() - begun if answered else float("inf"))
        client.close()
        time.sleep(PAUSE_S)
    return took


def told(name: str, took_s: list[float]) -> str:
    took_s = sorted(took_s)
    unanswered = took_s.count(float("inf"))
    median, p99 = (1000 * took_s[int(share * len(took_s))] for share in (0.5, 0.99))
    return (
        f"/healthz {name}: median {median:.0f} ms, p99 {p99:.0f} ms; {unanswered} of {len(took_s)} unanswered"
    )


def _hold(address: str, count: int) -> None:
    """Keep a number of connections open, whatever the service does."""
    at = urlsplit(address)
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(max(soft, count + 100), hard), hard))
    watched = selectors.DefaultSelector()
    while True:
        begun = time.perf_counter()
        for n in range(count - len(watched.get_map())):
            client = socket.create_connection((at.hostname, at.port))
            if n % 2:
                client.sendall(HALF_A_REQUEST)
            watched.register(client, selectors.EVENT_READ)
        while (left_s := begun + REFILL_S - time.perf_counter()) > 0:
            for key, _ in watched.select(left_s):
                assert isinstance(key.fileobj, socket.socket)
                try:
                    gone = not key.fileobj.recv(4096)
                except OSError:
                    gone = True
                if gone:
                    watched.unregister(key.fileobj)
                    key.fileobj.close()


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
