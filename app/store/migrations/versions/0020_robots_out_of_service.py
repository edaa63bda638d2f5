"""robots out of service"""

import sqlalchemy as sa
from alembic import op

revision = "0020"
down_revision = "0019"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "robots_out_of_service",
        sa.Column("world", sa.String(length=64), sa.ForeignKey("worlds.id"), primary_key=True),
        sa.Column("robot", sa.String(length=64), primary_key=True),
        sa.Column("since_s", sa.Double(), nullable=False),
        sa.Column("taken_by", sa.String(), nullable=False),
        sa.Column("reason", sa.String(), nullable=False),
        sa.Column("taken_at", sa.String(), nullable=False),
    )


def downgrade() -> None:
    op.drop_table("robots_out_of_service")
