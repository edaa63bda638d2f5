"""An operator's waiting times, over HTTP on loopback: goal to proposed plan, approval to the first robot moving.

uv run python -m benchmarks.latency [RUNS] [SPEED]
"""

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any
from urllib.parse import parse_qs, urlsplit

import httpx2

PLANNED = "move sample_1 to bay_7"
MOVED_M, TURNED_RAD = 0.02, 0.03
LIMIT_S = 60.0


def until(look: Callable[[], bool]) -> float:
    """Seconds until `look` returns True, polled every 5 ms.

    :raises TimeoutError: after a minute.
    """
    begun = time.perf_counter()
    while not look():
        if time.perf_counter() - begun > LIMIT_S:
            raise TimeoutError(f"nothing happened in {LIMIT_S:.0f} s")
        time.sleep(0.005)
    return time.perf_counter() - begun


def goal_to_plan_s(api: httpx2.Client, sentence: str) -> tuple[float, str]:
    """Seconds from posting a goal to its proposed plan, and the plan's id."""
    begun = time.perf_counter()
    goal = api.post("/v1/goals", json={"text": sentence}).json()
    path = f"/v1/goals/{goal['id']}"
    until(lambda: api.get(path).json()["state"] not in ("submitted", "waiting", "planning"))
    took_s = time.perf_counter() - begun
    planned = api.get(path).json()
    if planned["plan_id"] is None:
        raise RuntimeError(f"{sentence}: {planned['state']}, {planned['reason']}")
    return took_s, planned["plan_id"]


def approval_to_motion_s(api: httpx2.Client, plan_id: str) -> float:
    """Seconds from approving a plan to the first robot that has moved; waits for the mission's end."""
    before = _poses(api)
    begun = time.perf_counter()
    mission = api.post(f"/v1/plans/{plan_id}:approve").json()["mission_id"]
    until(lambda: any(_differ(pose, before[name]) for name, pose in _poses(api).items()))
    took_s = time.perf_counter() - begun
    until(lambda: api.get(f"/v1/missions/{mission}").json()["state"] == "completed")
    return took_s


def _poses(api: httpx2.Client) -> dict[str, dict[str, float]]:
    return {robot["name"]: robot["pose"] for robot in api.get("/v1/robots").json()["items"] if robot["pose"]}


def _differ(one: dict[str, Any], other: dict[str, Any]) -> bool:
    moved_m = abs(one["x_m"] - other["x_m"]) + abs(one["y_m"] - other["y_m"])
    return moved_m > MOVED_M or abs(one["heading_rad"] - other["heading_rad"]) > TURNED_RAD


def told(name: str, figures: Sequence[float]) -> str:
    return f"{name}: median {statistics.median(figures):.2f} s, {min(figures):.2f} to {max(figures):.2f}"


def measure(api: httpx2.Client, runs: int) -> None:
    to_plan, to_motion = [], []
    for _ in range(runs):
        took_s, plan_id = goal_to_plan_s(api, PLANNED)
        to_plan.append(took_s)
        api.post(f"/v1/plans/{plan_id}:reject", json={"comment": "measured"})
    for run in range(runs):
        _, plan_id = goal_to_plan_s(api, f"move sample_4 to {('bay_8', 'bay_11')[run % 2]}")
        to_motion.append(approval_to_motion_s(api, plan_id))
    print(told(f"goal to proposed plan ({PLANNED})", to_plan))
    print(told("approval to the first robot moving", to_motion))


@contextmanager
def served(speed: int = 1) -> Iterator[httpx2.Client]:
    """A client of a service of its own, with the sample store and a fresh record."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["macta", "serve", "--port", "0", "--data", folder, "--speed", str(speed)]
        service = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert service.stdout is not None
        try:
            address = urlsplit(service.stdout.readline().split(": ", 1)[1].strip())
            token = parse_qs(address.query)["token"][0]
            base = f"{address.scheme}://{address.netloc}"
            with httpx2.Client(base_url=base, headers={"authorization": f"Bearer {token}"}) as api:
                until(lambda: len(_poses(api)) == 4)
                yield api
        finally:
            service.terminate()
            service.wait()


def main(runs: int = 5, speed: int = 1) -> None:
    with served(speed) as api:
        measure(api, runs)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
