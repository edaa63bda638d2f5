"""What is not known of a world, from its facts."""

from collections.abc import Collection, Iterable

from app.store import Database, WorldRow
from app.store.event_log import EventLog
from app.store.facts import FactStore
from app.store.unknowns import list_unknowns
from planner import Fact
from tests.app.sample_store import Store

STORE = Store()
WORLD = "store"
LEFT = STORE.fact("near(yard_1, home_yard_1)")
WAY = ("yard_1", "near", "home_yard_1", "near", "door_1", "yard")
ON_ITS_WAY = Fact("under_way_navigate_1", WAY)


def test_a_robot_that_has_left_a_place_on_its_way_to_another_is_not_unknown(database: Database) -> None:
    """Not between the phases of an action; one that has lost its place by anything else is."""
    store = FactStore(EventLog(database), STORE.base)
    with database.write() as session:
        session.add(WorldRow(id=WORLD, title="Store", layout={}))

    def unknown(at_s: float, *, add: Iterable[Fact], remove: Iterable[Fact]) -> Collection[str]:
        with database.write() as session:
            store.change(session, WORLD, add=add, remove=remove, source="robot yard_1", at_s=at_s)
        with database.read() as session:
            found = list_unknowns(
                session,
                WORLD,
                known=store.believed(session, WORLD),
                samples=(),
                under_way=STORE.base.under_way,
            )
        return [one.name for one in found]

    assert ON_ITS_WAY.predicate in STORE.base.under_way
    assert unknown(1.0, add=[LEFT], remove=[]) == []
    assert unknown(2.0, add=[ON_ITS_WAY], remove=[LEFT]) == []
    assert unknown(3.0, add=[], remove=[ON_ITS_WAY]) == ["yard_1"]
