"""durations and releases"""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "durations",
        sa.Column("world", sa.String(length=64), nullable=False),
        sa.Column("action", sa.String(length=64), nullable=False),
        sa.Column("team", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("samples", sa.Integer(), nullable=False),
        sa.Column("mean", sa.Double(), nullable=False),
        sa.Column("variance", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["world"],
            ["worlds.id"],
        ),
        sa.PrimaryKeyConstraint("world", "action", "team"),
    )
    with op.batch_alter_table("worlds", schema=None) as batch_op:
        batch_op.add_column(sa.Column("releases", sa.Integer(), nullable=False, server_default="0"))

    with op.batch_alter_table("goals", schema=None) as batch_op:
        batch_op.add_column(sa.Column("releases_seen", sa.Integer(), nullable=False, server_default="0"))

    with op.batch_alter_table("plans", schema=None) as batch_op:
        batch_op.add_column(sa.Column("duration_factors", sa.JSON(), nullable=False, server_default="{}"))


def downgrade() -> None:
    with op.batch_alter_table("plans", schema=None) as batch_op:
        batch_op.drop_column("duration_factors")

    with op.batch_alter_table("goals", schema=None) as batch_op:
        batch_op.drop_column("releases_seen")

    with op.batch_alter_table("worlds", schema=None) as batch_op:
        batch_op.drop_column("releases")

    op.drop_table("durations")
