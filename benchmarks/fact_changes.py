"""What a report costs that changes a world's facts, by the size of the world.

    uv run python -m benchmarks.fact_changes [ROBOTS …]

Stores with 2 samples and 3 bays a robot, 4, 16 and 64 robots unless others are named, on SQLite. Each report is a
transaction: a robot has arrived somewhere. Printed: the facts of the world, CPU milliseconds of a transaction (median).
"""

import argparse
import tempfile
import time
from collections import defaultdict
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from statistics import median

from app.domain.world_model import belief_change, initial_facts
from app.domain.world_model.beliefs import REACHES, ROBOT_POSITION
from app.domain.world_model.layout import layout_of
from app.store import Database, WorldRow
from app.store.event_log import EventLog
from app.store.facts import FactStore, source_of
from app.store.migrate import migrate
from planner import Fact, load_knowledge_base
from robots.world import generate_world, store_shape

WORLD = "store"
REPORTS = 40


def measure(robots: int) -> tuple[int, float]:
    """The number of facts, and the CPU seconds of each report, in the median."""
    base = load_knowledge_base()
    half = robots // 2
    shape = store_shape(
        samples=2 * robots,
        aisles=half,
        store_robots=half,
        yard_robots=half,
        doors=max(2, robots // 4),
        bays=3 * robots,
        interchanges=robots,
    )
    world = generate_world(shape)
    facts = initial_facts(world, base)
    places = defaultdict[str, list[str]](list)
    for fact in sorted(facts):
        if fact.predicate == REACHES:
            places[fact.args[0]].append(fact.args[1])
    with (
        tempfile.TemporaryDirectory() as folder,
        closing(Database(f"sqlite:///{Path(folder)}/db")) as database,
    ):
        migrate(database)
        store = FactStore(EventLog(database), base)
        with database.write() as session:
            session.add(WorldRow(id=WORLD, title="Store", layout=layout_of(world)))
            session.flush()
            store.change(session, WORLD, add=facts, source="file", at_s=0.0)
        return len(facts), median(_reports(database, store, places))


def _reports(database: Database, store: FactStore, places: dict[str, list[str]]) -> Sequence[float]:
    took_s = []
    for number in range(REPORTS):
        robot = sorted(places)[number % len(places)]
        place = places[robot][number % len(places[robot])]
        began_s = time.process_time()
        with database.write() as session:
            known = store.read_locked(session, WORLD)
            change = belief_change(known.facts, [Fact(ROBOT_POSITION, (robot, "in", place))])
            at_s = float(number + 1)
            known.change(add=change.add, remove=change.remove, source=source_of(robot), at_s=at_s)
        took_s.append(time.process_time() - began_s)
    return took_s


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("robots", type=int, nargs="*", default=[4, 16, 64])
    for robots in options.parse_args().robots:
        facts, took_s = measure(robots)
        print(f"{robots} robots, {facts} facts: {1000 * took_s:.1f} CPU-ms a report", flush=True)


if __name__ == "__main__":
    main()
