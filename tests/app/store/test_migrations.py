"""Migrations: an old record comes up to date with its rows, and the tables are what the code says."""

from collections.abc import Callable, Iterator
from json import dumps
from pathlib import Path

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import JSON, Connection, UniqueConstraint, inspect, text

from app.domain.errors import Invalid
from app.store import Base, Database
from app.store.migrate import migrate, migration_config, newest_migration
from tests.databases import ON_BOTH, fresh

pytestmark = ON_BOTH


@pytest.fixture
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """Without tables."""
    with fresh(request.param, tmp_path) as url:
        yield url


def by_migrations(record: Database) -> None:
    with record.engine.connect() as connection:
        command.upgrade(migration_config(connection), "head")
        connection.commit()


@pytest.mark.parametrize("make", [by_migrations, migrate])
def test_the_tables_are_those_that_the_code_declares(
    database_url: str, make: Callable[[Database], None]
) -> None:
    record = Database(database_url)
    make(record)
    with record.engine.connect() as connection:
        context = MigrationContext.configure(connection)
        assert compare_metadata(context, Base.metadata) == []
        assert _unique(connection) == {  # which it does not compare where they have no name
            (name, tuple(sorted(column.name for column in one.columns)))
            for name, table in Base.metadata.tables.items()
            for one in table.constraints
            if isinstance(one, UniqueConstraint)
        }
        newest = ScriptDirectory.from_config(migration_config(connection)).get_current_head()
        assert context.get_current_revision() == newest == newest_migration()
    record.close()


def _unique(connection: Connection) -> set[tuple[str, tuple[str, ...]]]:
    """Tables of the database and their columns that are unique together."""
    found = inspect(connection)
    return {
        (name, tuple(sorted(one["column_names"])))
        for name in Base.metadata.tables
        for one in found.get_unique_constraints(name)
    }


def test_a_record_of_the_first_version_keeps_its_rows(database_url: str) -> None:
    record = Database(database_url)
    with record.engine.connect() as connection:
        command.upgrade(migration_config(connection), "0001")
        connection.execute(
            text("INSERT INTO worlds (id, title, layout, version) VALUES ('lab', 'Lab', '{}', 7)")
        )
        connection.commit()
    migrate(record)
    with record.engine.connect() as connection:
        rows = connection.execute(text("SELECT id, version, releases FROM worlds")).all()
    assert [tuple(row) for row in rows] == [("lab", 7, 0)]
    record.close()


def test_orders_and_overdue_missions_of_before_are_kept_as_data(database_url: str) -> None:
    record = Database(database_url)
    with record.engine.connect() as connection:
        command.upgrade(migration_config(connection), "0012")
        for insert in BEFORE_0014:
            connection.execute(text(insert))
        connection.commit()
    migrate(record)
    with record.engine.connect() as connection:
        missions = connection.execute(text("SELECT reason, is_overdue FROM missions ORDER BY id")).all()
        orders = connection.execute(text("SELECT control, control_number FROM scripts ORDER BY id")).all()
    assert [(reason, bool(overdue)) for reason, overdue in missions] == [
        ("no answer from fred", True),
        ("", True),
        ("so it was; its deadline has passed", False),
        ("", False),
    ]
    assert [tuple(row) for row in orders] == [("pause", 3), (None, None)]
    record.close()


MISSION = (
    "INSERT INTO missions (id, workflow, goal_id, plan_id, world, state, reason, estimate_s, original_estimate_s, "
    "margin_s, cancel_requested, created_at) VALUES ('{id}', '{id}', 'g', 'p{id}', 'lab', '{state}', '{reason}', "
    "1, 1, 1, false, 'now')"
)
SCRIPT = (
    "INSERT INTO scripts (id, mission_id, plan_id, robot, body, delivery, control, orders, stopping, packets, detail, "
    "perceived) VALUES ('{id}', '1', 'p1', 'fred', '{{}}', 'acknowledged', {control}, 3, false, '{{}}', '', '[]')"
)
PLAN = (
    "INSERT INTO plans (id, goal_id, world, state, reason, body, world_version, created_at) "
    "VALUES ('p{id}', 'g', 'lab', 'approved', '', '{{}}', 1, 'now')"
)
BEFORE_0014 = [
    "INSERT INTO worlds (id, title, layout, version) VALUES ('lab', 'Lab', '{}', 7)",
    "INSERT INTO goals (id, world, text, goal, priority, auto_approve, state, reason, attempts, created_by, "
    "created_at, updated_at) VALUES ('g', 'lab', '', '[]', 0, false, 'committed', '', 1, 'me', 'now', 'now')",
    *(PLAN.format(id=number) for number in range(1, 5)),
    MISSION.format(id=1, state="unknown", reason="no answer from fred; its deadline has passed"),
    MISSION.format(id=2, state="running", reason="its deadline has passed"),
    MISSION.format(id=3, state="failed", reason="so it was; its deadline has passed"),
    MISSION.format(id=4, state="running", reason=""),
    SCRIPT.format(id="a", control="'pause:3'"),
    SCRIPT.format(id="b", control="NULL"),
]


def test_goals_that_waited_in_submitted_become_waiting_and_back(database_url: str) -> None:
    record = Database(database_url)
    goal = (
        "INSERT INTO goals (id, world, text, goal, priority, auto_approve, state, reason, attempts, created_by, "
        "created_at, updated_at) VALUES (:id, 'lab', '', '[]', 0, false, 'submitted', :reason, 1, 'me', '', '')"
    )
    rows = {"new": "", "waits": "waits for mission m", "again": "the plan was overtaken: in(a, b)"}
    with record.engine.connect() as connection:
        command.upgrade(migration_config(connection), "0012")
        connection.execute(
            text("INSERT INTO worlds (id, title, layout, version) VALUES ('lab', '', '{}', 1)")
        )
        for name, reason in rows.items():
            connection.execute(text(goal), {"id": name, "reason": reason})
        connection.commit()
        command.upgrade(migration_config(connection), "0013")
        states = connection.execute(text("SELECT id, state FROM goals")).all()
        assert {one.id: one.state for one in states} == {
            "new": "submitted",
            "waits": "waiting",
            "again": "submitted",
        }
        command.downgrade(migration_config(connection), "0012")
        assert set(connection.execute(text("SELECT state FROM goals")).scalars()) == {"submitted"}
    record.close()


def test_areas_to_keep_out_of_become_zones_and_back(database_url: str) -> None:
    record = Database(database_url)
    area = {"name": "spill", "x": [0, 2], "y": [0, 2]}
    zone = {**area, "rule": "keep_out", "max_speed_m_s": None}
    edition = {
        "document": {"name": "lab", "keep_out": [area]},
        "edits": [{"edit": "add_keep_out", "area": area}, {"edit": "remove_robot", "name": "fred"}],
        "undo": [{"edit": "remove_keep_out", "name": "spill"}],
    }
    insert = (
        "INSERT INTO world_editions (world, edition, document, file_digest, edits, undo, actor, reason, at_s, made_at, "
        "delivery, detail) VALUES ('lab', 1, :document, '', :edits, :undo, 'me', '', 0, '', 'taken_up', '')"
    )
    read = text("SELECT document, edits, undo FROM world_editions").columns(
        document=JSON, edits=JSON, undo=JSON
    )
    with record.engine.connect() as connection:
        command.upgrade(migration_config(connection), "0023")
        layout = dumps(edition["document"])
        connection.execute(
            text(
                "INSERT INTO worlds (id, title, layout, version, releases) VALUES ('lab', '', :layout, 1, 0)"
            ),
            {"layout": layout},
        )
        connection.execute(text(insert), {name: dumps(value) for name, value in edition.items()})
        connection.commit()
        command.upgrade(migration_config(connection), "0028")
        row = connection.execute(read).one()
        assert row.document == {"name": "lab", "zones": [zone]}
        assert row.edits == [{"edit": "add_zone", "zone": zone}, {"edit": "remove_robot", "name": "fred"}]
        assert row.undo == [{"edit": "remove_zone", "name": "spill"}]
        shown = connection.execute(text("SELECT layout FROM worlds").columns(layout=JSON)).scalar_one()
        assert shown == {"name": "lab", "zones": [zone]}
        command.downgrade(migration_config(connection), "0023")
        assert connection.execute(read).one()._asdict() == edition
    record.close()


def test_a_database_of_a_newer_version_is_refused_and_left_as_it_is(database_url: str) -> None:
    record = Database(database_url)
    migrate(record)
    with record.write() as session:
        session.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(
        Invalid, match=r"newer version of Macta: its migration is 9999, this version has \d{4}"
    ):
        migrate(record)
    with record.read() as session:
        assert session.scalar(text("SELECT version_num FROM alembic_version")) == "9999"
    record.close()


@pytest.mark.parametrize(
    ("made_by", "named"),
    [
        (["CREATE TABLE moz_places (url TEXT)"], "it holds moz_places"),
        (
            [
                "CREATE TABLE alembic_version (version_num TEXT)",
                "INSERT INTO alembic_version VALUES ('ae10')",
            ],
            "'ae10'",
        ),
    ],
)
def test_a_database_of_another_program_is_refused_and_left_as_it_is(
    database_url: str, made_by: list[str], named: str
) -> None:
    record = Database(database_url)
    with record.write() as session:
        for statement in made_by:
            session.execute(text(statement))
    before = inspect(record.engine).get_table_names()
    with pytest.raises(Invalid, match=f"another program's.*{named}"):
        migrate(record)
    assert inspect(record.engine).get_table_names() == before
    record.close()
