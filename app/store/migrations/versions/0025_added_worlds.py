"""worlds added while the service runs"""

import sqlalchemy as sa
from alembic import op

revision = "0025"
down_revision = "0024"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "added_worlds",
        sa.Column("world", sa.String(length=64), sa.ForeignKey("worlds.id"), primary_key=True),
        sa.Column("document", sa.JSON(), nullable=False),
        sa.Column("rate", sa.Double()),
        sa.Column("added_by", sa.String(), nullable=False),
        sa.Column("reason", sa.String(), nullable=False),
        sa.Column("added_at", sa.String(), nullable=False),
        sa.Column("removed_at", sa.String()),
        sa.Column("removed_by", sa.String()),
        sa.Column("removal_reason", sa.String()),
    )


def downgrade() -> None:
    op.drop_table("added_worlds")
