"""How soon a change of a world is effective under load: `python -m benchmarks.world_changes [CHANGES]`.

`macta serve` carries out missions and gets goals from four clients all the time. A sample or a robot is added over the
API, then removed. A change is effective once the running world goes on so, as its event says; a robot also once its
telemetry is known. Each change must have its two events, and the events' numbers no gap.
"""

import itertools
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import httpx2

from tests.scenarios.serving import macta_serve

TOKEN = "a-token-of-the-benchmark"
WORLD = "/v1/worlds/sample_store"
CLIENTS = 4
LONGEST_S = 30.0
ERRANDS = (
    "move sample_2 to bay_3",
    "move sample_2 to bay_2",
    "move sample_4 to bay_12",
    "move sample_4 to bay_11",
)


def main(changes: int) -> None:
    with TemporaryDirectory() as folder, macta_serve(Path(folder), token=TOKEN) as served:
        headers = {"authorization": f"Bearer {TOKEN}"}
        with (
            httpx2.Client(base_url=served.address, headers=headers, timeout=60) as api,
            load(served.address, headers),
        ):
            time.sleep(5)
            samples, robots = [], []
            for number in range(changes):
                sample = {"name": f"added_{number}", "at": "bay_6"}
                samples.append(effective_s(api, {"edit": "add_sample", "sample": sample}))
                effective_s(api, {"edit": "remove_sample", "name": sample["name"]})
                robot = {"name": f"robot_{number}", "compartment": "yard", "start": [4, 2.6, 90]}
                robots.append(effective_s(api, {"edit": "add_robot", "robot": robot}, robot=robot["name"]))
                effective_s(api, {"edit": "remove_robot", "name": robot["name"]})
            print(f"sample added: {words(samples)}")
            print(f"robot added, until its telemetry is known: {words(robots)}")
            print(lost(api, 4 * changes))


def effective_s(api: httpx2.Client, edit: Mapping[str, Any], *, robot: str | None = None) -> float:
    """Seconds from the request until the change is effective."""
    began_s = time.monotonic()
    made = api.post(f"{WORLD}/changes", json={"edits": [edit], "reason": "benchmark"})
    made.raise_for_status()
    while time.monotonic() < began_s + LONGEST_S:
        newest = api.get(f"{WORLD}/changes").json()["items"][0]
        if newest["delivery"] == "taken_up" and (robot is None or is_heard(api, robot)):
            return time.monotonic() - began_s
        time.sleep(0.01)
    raise TimeoutError(f"not effective within {LONGEST_S} s: {newest}")


def is_heard(api: httpx2.Client, robot: str) -> bool:
    return api.get(f"/v1/robots/{robot}").json()["pose"] is not None


@contextmanager
def load(url: str, headers: Mapping[str, str]) -> Iterator[None]:
    """Missions, and clients that ask and state goals without a pause."""
    over = threading.Event()

    def ask(number: int) -> None:
        with httpx2.Client(base_url=url, headers=headers, timeout=60) as api:
            while not over.is_set():
                if number == 0:
                    for text in ERRANDS:
                        api.post("/v1/goals", json={"text": text, "auto_approve": True, "effort_s": 0})
                    over.wait(5.0)
                else:
                    api.post("/v1/goals:check", json={"text": "move sample_1 to bay_7"})
                    api.get(f"{WORLD}/facts")

    threads = [threading.Thread(target=ask, args=(number,)) for number in range(CLIENTS)]
    for thread in threads:
        thread.start()
    try:
        yield
    finally:
        over.set()
        for thread in threads:
            thread.join()


def lost(api: httpx2.Client, changes: int) -> str:
    """Whether each change has its events, in words."""
    told: dict[str, list[int]] = {"world.changed": [], "world.change_taken_up": []}
    numbers = []
    with api.stream("GET", "/v1/events", headers={"last-event-id": "0"}) as stream:
        for line in stream.iter_lines():
            if line.startswith("id:"):
                numbers.append(int(line.removeprefix("id:")))
            for kind, editions in told.items():
                if line.startswith("data:") and f'"{kind}"' in line:
                    editions.append(int(line.partition('"edition":')[2].partition(",")[0].strip(" }")))
            if len(told["world.change_taken_up"]) >= changes:
                break
    expected = list(range(1, changes + 1))
    gaps = [one for one, after in itertools.pairwise(numbers) if after != one + 1]
    is_whole = all(sorted(editions) == expected for editions in told.values()) and not gaps
    return f"{changes} changes, {len(numbers)} events: {'none lost' if is_whole else f'LOST: {told}, {gaps}'}"


def words(seconds: Sequence[float]) -> str:
    return f"median {median(seconds):.2f} s, longest {max(seconds):.2f} s of {len(seconds)}"


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
