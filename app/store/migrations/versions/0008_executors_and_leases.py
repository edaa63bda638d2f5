"""executors and leases"""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "executors",
        sa.Column("id", sa.String(length=120), primary_key=True),
        sa.Column("serves", sa.JSON(), nullable=False),
        sa.Column("host", sa.String(), nullable=False),
        sa.Column("pid", sa.Integer(), nullable=False),
        sa.Column("started_at", sa.String(), nullable=False),
        sa.Column("seen_at", sa.Double(), nullable=False),
    )
    op.create_table(
        "leases",
        sa.Column("world", sa.String(length=64), primary_key=True),
        sa.Column("holder", sa.String(length=120), nullable=False),
    )


def downgrade() -> None:
    op.drop_table("leases")
    op.drop_table("executors")
