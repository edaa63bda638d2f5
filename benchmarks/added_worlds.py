"""How soon an added world runs, and what removed ones leave behind: `python -m benchmarks.added_worlds [ROUNDS]`.

A world, a copy of the sample store under another name, is added to a running `macta serve` and removed, repeatedly.
Measured are the answer to POST, the first telemetry, the first proposed plan (its goal is stated right after POST), the
CPU time of all processes of the service until both are there, less what the service takes idle, and the world's memory.
What is left of the rounds is the service's open files, threads, child processes and resident memory, before and after.
"""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import httpx2

from app.planning.pool.process_tree import tree_of
from benchmarks.processes import pss_mb, tree_cpu_s
from robots.world import load_world
from tests.scenarios.serving import Served, macta_serve

TOKEN = "a-token-of-the-benchmark"
LONGEST_S = 300.0
IDLE_S = 5.0
LOOK_S = 0.02


def main(rounds: int) -> None:
    with (
        TemporaryDirectory() as folder,
        macta_serve(Path(folder), token=TOKEN) as served,
        served.client() as api,
    ):
        wait(lambda: api.get("/readyz").json().get("compilation") == "compiled")
        measured = [
            once(served, api, f"hall_{number}") for number in range(2)
        ]  # what is read and cached once
        before = kept(served)
        measured = [once(served, api, f"hall_{number % 2}") for number in range(rounds)]
        for name in measured[0]:
            values = [one[name] for one in measured]
            print(f"{name}: median {median(values):.2f}, greatest {max(values):.2f} of {rounds}")
        time.sleep(IDLE_S)
        after = kept(served)
        for name, value in before.items():
            print(f"{name}: {value:.0f} before {rounds} rounds, {after[name]:.0f} after")


def once(served: Served, api: httpx2.Client, name: str) -> dict[str, float]:
    """Add the world, have a goal planned, and remove it."""
    pid = served.process.pid
    known = {one.pid for one in tree_of(pid)}
    idle_cpu_s = tree_cpu_s(pid)
    time.sleep(IDLE_S)
    idle = (tree_cpu_s(pid) - idle_cpu_s) / IDLE_S
    cpu_s = tree_cpu_s(pid)
    began_s = time.monotonic()
    api.post("/v1/worlds", json=world(name)).raise_for_status()
    added_s = time.monotonic() - began_s
    goal = (
        api.post("/v1/goals", json={"world": name, "text": "move sample_1 to bay_7"})
        .raise_for_status()
        .json()
    )
    times: dict[str, float] = {}
    wait(lambda: look(api, name, goal["id"], times, began_s))
    took_s = time.monotonic() - began_s
    cpu_s = tree_cpu_s(pid) - cpu_s - idle * took_s
    memory_mb = pss_mb({one.pid for one in tree_of(pid)} - known)
    api.post(f"/v1/goals/{goal['id']}:cancel", json={}).raise_for_status()
    began_s = time.monotonic()
    api.delete(f"/v1/worlds/{name}").raise_for_status()
    return {
        "POST to 201, s": added_s,
        "POST to first telemetry, s": times["telemetry"],
        "POST to first proposed plan, s": times["plan"],
        "CPU time until both, s": cpu_s,
        "memory of the world's process, MB": memory_mb,
        "DELETE to 204, s": time.monotonic() - began_s,
    }


def look(api: httpx2.Client, name: str, goal: str, times: dict[str, float], began_s: float) -> bool:
    """Note what is there for the first time; True once all is."""
    now_s = time.monotonic() - began_s
    if "plan" not in times and api.get(f"/v1/goals/{goal}").json()["state"] == "planned":
        times["plan"] = now_s
    if "telemetry" not in times and api.get(f"/v1/robots/{name}_yard_1").json()["pose"] is not None:
        times["telemetry"] = now_s
    return len(times) == 2


def kept(served: Served) -> dict[str, float]:
    pid = served.process.pid
    status = Path(f"/proc/{pid}/status").read_text()
    fields = dict(line.split(":", 1) for line in status.splitlines())
    return {
        "open files": len(list(Path(f"/proc/{pid}/fd").iterdir())),
        "threads": int(fields["Threads"]),
        "child processes": len(tree_of(pid)) - 1,
        "resident memory of the service, MB": int(fields["VmRSS"].split()[0]) / 1024,
    }


def world(name: str) -> dict[str, Any]:
    store = load_world("sample_store")
    text = json.dumps(store.model_dump(mode="json"))
    for robot in store.robots:
        text = text.replace(f'"{robot.name}"', f'"{name}_{robot.name}"')
    return {**json.loads(text), "name": name}


def wait(true: Callable[[], bool]) -> None:
    give_up_s = time.monotonic() + LONGEST_S
    while not true():
        if time.monotonic() > give_up_s:
            raise TimeoutError(f"not within {LONGEST_S} s")
        time.sleep(LOOK_S)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
