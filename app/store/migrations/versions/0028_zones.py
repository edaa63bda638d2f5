"""areas to keep out of are zones"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0028"
down_revision = "0027"
branch_labels = None
depends_on = None

EDITIONS = sa.table(
    "world_editions",
    sa.column("world", sa.String),
    sa.column("edition", sa.Integer),
    sa.column("document", sa.JSON),
    sa.column("edits", sa.JSON),
    sa.column("undo", sa.JSON),
)
WORLDS = sa.table("worlds", sa.column("id", sa.String), sa.column("layout", sa.JSON))
RULE = {"rule": "keep_out", "max_speed_m_s": None}


def upgrade() -> None:
    connection = op.get_bind()
    for row in connection.execute(sa.select(EDITIONS)).all():
        connection.execute(
            EDITIONS.update()
            .where(EDITIONS.c.world == row.world, EDITIONS.c.edition == row.edition)
            .values(
                document=_world_with_zones(row.document),
                edits=[_edit_of_zone(edit) for edit in row.edits],
                undo=[_edit_of_zone(edit) for edit in row.undo],
            )
        )
    for row in connection.execute(sa.select(WORLDS)).all():
        connection.execute(
            WORLDS.update().where(WORLDS.c.id == row.id).values(layout=_world_with_zones(row.layout))
        )


def downgrade() -> None:
    connection = op.get_bind()
    for row in connection.execute(sa.select(EDITIONS)).all():
        connection.execute(
            EDITIONS.update()
            .where(EDITIONS.c.world == row.world, EDITIONS.c.edition == row.edition)
            .values(
                document=_world_with_areas(row.document),
                edits=[_edit_of_area(edit) for edit in row.edits],
                undo=[_edit_of_area(edit) for edit in row.undo],
            )
        )
    for row in connection.execute(sa.select(WORLDS)).all():
        connection.execute(
            WORLDS.update().where(WORLDS.c.id == row.id).values(layout=_world_with_areas(row.layout))
        )


def _world_with_zones(world: dict[str, Any]) -> dict[str, Any]:
    if "keep_out" not in world:
        return world
    rest = {name: value for name, value in world.items() if name != "keep_out"}
    return rest | {"zones": [area | RULE for area in world["keep_out"]]}


def _edit_of_zone(edit: dict[str, Any]) -> dict[str, Any]:
    match edit:
        case {"edit": "add_keep_out", "area": area}:
            return {"edit": "add_zone", "zone": area | RULE}
        case {"edit": "remove_keep_out", "name": name}:
            return {"edit": "remove_zone", "name": name}
        case _:
            return edit


def _world_with_areas(world: dict[str, Any]) -> dict[str, Any]:
    """The zones with other rules are lost: earlier versions have none."""
    if "zones" not in world:
        return world
    rest = {name: value for name, value in world.items() if name != "zones"}
    return rest | {"keep_out": [_area(zone) for zone in world["zones"] if zone["rule"] == "keep_out"]}


def _edit_of_area(edit: dict[str, Any]) -> dict[str, Any]:
    match edit:
        case {"edit": "add_zone", "zone": zone}:
            return {"edit": "add_keep_out", "area": _area(zone)}
        case {"edit": "remove_zone", "name": name}:
            return {"edit": "remove_keep_out", "name": name}
        case _:
            return edit


def _area(zone: dict[str, Any]) -> dict[str, Any]:
    return {name: zone[name] for name in ("name", "x", "y")}
