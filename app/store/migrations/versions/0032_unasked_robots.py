"""robots that do not understand status queries"""

import sqlalchemy as sa
from alembic import op

revision = "0032"
down_revision = "0031"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "unasked_robots",
        sa.Column("world", sa.String(length=64), sa.ForeignKey("worlds.id"), primary_key=True),
        sa.Column("robot", sa.String(length=64), primary_key=True),
        sa.Column("reason", sa.String(), nullable=False),
        sa.Column("noted_at", sa.String(), nullable=False),
    )


def downgrade() -> None:
    op.drop_table("unasked_robots")
