"""indices for pages of goals, plans and missions by each filter, for abandoned scripts and old messages"""

import sqlalchemy as sa
from alembic import op

revision = "0018"
down_revision = "0017"
branch_labels = None
depends_on = None

FILTERS = {
    "goals": ((), ("state",), ("world",), ("world", "state")),
    "plans": ((), ("state",), ("goal_id", "state")),
    "missions": ((), ("state",), ("world",), ("world", "state")),
}
REPLACED = (
    ("goals", "state"),
    ("goals", "world"),
    ("plans", "goal_id"),
    ("missions", "state"),
    ("missions", "world"),
    ("scripts", "delivery"),
)


def upgrade() -> None:
    for table, column in REPLACED:
        op.drop_index(f"ix_{table}_{column}", table)
    for table, filters in FILTERS.items():
        for columns in filters:
            op.create_index(_name(table, columns), table, [*columns, "created_at", "id"])
    abandoned = sa.column("abandoned", sa.Boolean) == sa.true()
    op.create_index(
        "ix_scripts_abandoned",
        "scripts",
        ["mission_id"],
        sqlite_where=abandoned,
        postgresql_where=abandoned,
    )
    op.create_index("ix_messages_recorded_at", "messages", ["recorded_at"])


def downgrade() -> None:
    op.drop_index("ix_messages_recorded_at", "messages")
    op.drop_index("ix_scripts_abandoned", "scripts")
    for table, filters in FILTERS.items():
        for columns in filters:
            op.drop_index(_name(table, columns), table)
    for table, column in REPLACED:
        op.create_index(f"ix_{table}_{column}", table, [column])


def _name(table: str, columns: tuple[str, ...]) -> str:
    return "_".join(("ix", table, *columns, "newest"))
