"""holds"""

import sqlalchemy as sa
from alembic import op

revision = "0026"
down_revision = "0025"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "holds",
        sa.Column("id", sa.String(length=120), primary_key=True),
        sa.Column("world", sa.String(length=64), sa.ForeignKey("worlds.id"), nullable=False),
        sa.Column("places", sa.JSON(), nullable=False),
        sa.Column("kept", sa.JSON(), nullable=False),
        sa.Column("until", sa.JSON(), nullable=False),
        sa.Column("ends_at", sa.Double(), nullable=True),
        sa.Column("ends_at_s", sa.Double(), nullable=True),
        sa.Column("state", sa.String(), nullable=False),
        sa.Column("goal_id", sa.String(length=120), nullable=False),
        sa.Column("text", sa.String(), nullable=False),
        sa.Column("created_by", sa.String(), nullable=False),
        sa.Column("created_at", sa.String(), nullable=False),
        sa.Column("ending", sa.String(), nullable=True),
        sa.Column("ended_by", sa.String(), nullable=True),
        sa.Column("ended_at", sa.String(), nullable=True),
        sa.Column("comment", sa.String(), nullable=False),
    )
    op.create_index("ix_holds_world_state", "holds", ["world", "state"])


def downgrade() -> None:
    op.drop_index("ix_holds_world_state", "holds")
    op.drop_table("holds")
