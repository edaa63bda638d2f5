"""Each process of a service knows the newest edition of its worlds."""

from app.store import Database, EditionRow, WorldRow
from app.store.editions import WorldDirectory, newest_edition
from robots.world import Edition, WorldFile, digest_of, load_world
from tests.databases import ON_BOTH

FILE = load_world("sample_store")
NAME = FILE.name


def titled(title: str) -> WorldFile:
    return WorldFile.model_validate({**FILE.model_dump(), "title": title})


def record(database: Database, number: int, world: WorldFile) -> None:
    with database.write() as session:
        if session.get(WorldRow, NAME) is None:
            session.add(WorldRow(id=NAME, title="", layout={}))
            session.flush()
        session.add(
            EditionRow(
                world=NAME,
                edition=number,
                document=world.model_dump(mode="json"),
                file_digest=digest_of(FILE),
                edits=[{"edit": "remove_sample", "name": "sample_1"}],
                undo=[],
                actor="somebody",
                reason="",
                at_s=0.0,
            )
        )


@ON_BOTH
def test_what_another_process_has_recorded_is_read_and_told_once(database: Database) -> None:
    worlds = WorldDirectory(database, {NAME: FILE})
    titles = worlds.each(lambda world: world.title)
    renewed: list[str] = []
    worlds.renewed.append(lambda world: renewed.append(world.title))
    record(database, 1, titled("first"))
    record(database, 2, titled("second"))
    for _ in range(2):
        with database.read() as session:
            worlds.read(session)
    assert (worlds.edition(NAME).number, worlds[NAME].title, titles[NAME]) == (2, "second", "second")
    assert renewed == ["second"]
    worlds.put(Edition(1, titled("late")))
    assert worlds[NAME].title == "second"


def test_another_file_is_a_further_edition_once(database: Database) -> None:
    record(database, 1, titled("changed"))
    other = titled("another file")
    for _ in range(2):
        worlds = WorldDirectory(database, {NAME: other})
        with database.write() as session:
            worlds.start(session)
        assert (worlds.edition(NAME).number, worlds[NAME].title) == (2, "another file")
    with database.read() as session:
        assert newest_edition(session, FILE).number == 3  # and back again
