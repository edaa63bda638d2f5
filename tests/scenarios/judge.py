"""Whether what a witness saw is true: the record and the simulated world, after whatever was killed."""

from collections.abc import Collection
from pathlib import Path

from app.cli import ground_truth
from app.cli.ground_truth import holds
from app.cli.trials.checks import RecordedReports, executed_twice, unfinished_goals, untrue_goals
from app.store import Database, WorldRow
from robots.world import load_world
from sim.truth import Truth
from tests.scenarios.witness import WORLD, Witness


def judge(seen: Witness, *, data: Path, database_url: str, lasting: Collection[str] | None = None) -> None:
    """What must hold whatever was killed.

    :param data: the folder in which the world was kept.
    :param lasting: ids of the goals that no later goal undoes; None: all of them.
    """
    assert len(seen.accepted) == len(seen.goals)
    real, world = snapshot_truth(data), load_world(WORLD)
    assert {goal["state"] for goal in seen.final} == {"finished"}, seen.final
    assert not unfinished_goals(seen.final)
    last = [goal for goal in seen.final if lasting is None or goal["id"] in lasting]
    assert not untrue_goals(last, lambda fact: holds(fact, world, real)), real.samples
    assert not seen.observer.complaints
    record = RecordedReports.read(database_url)
    assert set(seen.decided.items()) <= {(s.plan_id, s.mission_id) for s in record.scripts}
    assert not executed_twice(record)


def snapshot_truth(data: Path) -> Truth:
    """The world as the last snapshot in a data folder has it."""
    return ground_truth.snapshot_truth(data, load_world(WORLD))


def run_of(database_url: str) -> str | None:
    """The run of the world that the record tells of."""
    database = Database(database_url)
    try:
        with database.read() as session:
            return session.get_one(WorldRow, WORLD).run
    finally:
        database.close()
