"""Kills `macta serve` and all processes that it started by SIGKILL, again and again, at random instants.

    uv run python -m benchmarks.kill_storm --kills 40 --seed 1

After each start more goals are submitted, under idempotency keys, and every earlier goal once more. One kill in
four comes while the service starts. After the last start it runs until every goal has ended; then record and simulated
world must agree, and no packet may have been carried out twice.
"""

import argparse
import random
import tempfile
import threading
import time
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path

import httpx2
from sqlalchemy import select

from app.cli.trials.service_process import Installation
from app.domain.events import GoalFinished
from app.store import Database, EventRow
from tests.scenarios.judge import judge
from tests.scenarios.witness import WORLD, Witness

LATEST_S = 6.0
"""The service is killed at most this long after it answers."""
BAYS = {
    "sample_1": ["bay_1", "bay_4", "bay_9"],
    "sample_2": ["bay_2", "bay_6", "bay_10"],
    "sample_3": ["bay_5", "bay_3", "bay_7"],
    "sample_4": ["bay_11", "bay_8", "bay_12"],
}
"""Each sample is moved among bays of its own, so that every goal is possible; it starts in the first, or at a door."""
GIVE_UP_S = 1200.0


def storm(folder: Path, *, kills: int, seed: int, speed: float, goals: int = 1) -> Witness:
    """
    :param goals: so many more after each start, of different samples.
    :raises AssertionError: if something was lost, done twice, or is not as recorded.
    """
    chance = random.Random(seed)
    given: dict[str, str] = {}
    last = {sample: bays[0] for sample, bays in BAYS.items()}
    seen = Witness(given)
    installation = Installation(
        data=folder / "data", world=WORLD, token="a-token-for-the-storm", speed=speed, environment={}
    )
    for number in range(kills):
        for one, sample in enumerate(chance.sample(sorted(BAYS), goals)):
            last[sample] = chance.choice([bay for bay in BAYS[sample] if bay != last[sample]])
            given[f"goal-{number}-{one}"] = f"move {sample} to {last[sample]}"
        with installation.running(number) as service:
            if chance.random() < 0.25:
                time.sleep(chance.uniform(0.3, 4.0))
                when = "while it starts"
            else:
                service.address()
                killer = threading.Timer(chance.uniform(0.3, LATEST_S), service.kill)
                killer.start()
                with suppress(httpx2.TransportError), service.api() as api:  # it is cut off
                    state_and_look(seen, api)
                killer.join()
                when = "when it runs"
        print(f"kill {number + 1:3}, {when}: {len(seen.accepted)} goals, {ended(seen)} ended", flush=True)
    with installation.running(kills) as service, service.api() as api:
        seen.state_goals(api)
        give_up_s = time.monotonic() + GIVE_UP_S
        while not seen.over:
            assert time.monotonic() < give_up_s, seen.final
            seen.look(api)
            time.sleep(0.1)
        service.end()
    url = installation.database_url
    judge(seen, data=installation.data, database_url=url, lasting=ended_last(seen, url))
    return seen


def ended_last(seen: Witness, database_url: str) -> Collection[str]:
    """For each sample the goal that ended last: goals that are open at the same time are carried out in any order."""
    database = Database(database_url)
    with database.read() as session:
        endings = (
            select(EventRow.subject).where(EventRow.type.in_(GoalFinished.types())).order_by(EventRow.seq)
        )
        ended = session.scalars(endings).all()
    database.close()
    samples = {seen.accepted[key]: text.split()[1] for key, text in seen.goals.items()}
    return {samples[goal]: goal for goal in ended}.values()


def state_and_look(seen: Witness, api: httpx2.Client) -> None:
    seen.state_goals(api)
    while True:
        seen.look(api)
        time.sleep(0.1)


def ended(seen: Witness) -> int:
    return sum(goal["state"] == "finished" for goal in seen.final)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("--kills", type=int, default=40)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--goals", type=int, default=1, choices=range(1, 5), help="stated after each start")
    options.add_argument("--speed", type=float, default=12.0, help="world seconds per wall-clock second")
    wanted = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        seen = storm(
            Path(folder), kills=wanted.kills, seed=wanted.seed, speed=wanted.speed, goals=wanted.goals
        )
    outcomes = [goal["outcome"] for goal in seen.final]
    counts = ", ".join(f"{outcomes.count(one)} {one}" for one in sorted(set(outcomes)))
    print(f"{wanted.kills} kills, {len(seen.goals)} goals: {counts}; 0 lost, 0 done twice, record true")


if __name__ == "__main__":
    main()
