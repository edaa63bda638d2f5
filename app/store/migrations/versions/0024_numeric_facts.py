"""numeric facts"""

import sqlalchemy as sa
from alembic import op

revision = "0024"
down_revision = "0023"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("worlds", sa.Column("numbers_version", sa.Integer(), nullable=False, server_default="0"))
    op.create_table(
        "numbers",
        sa.Column("world", sa.String(length=64), sa.ForeignKey("worlds.id"), primary_key=True),
        sa.Column("term", sa.String(length=400), primary_key=True),
        sa.Column("quantity", sa.String(), nullable=False),
        sa.Column("args", sa.JSON(), nullable=False),
        sa.Column("value", sa.Double(), nullable=False),
        sa.Column("source", sa.String(), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.Column("version", sa.Integer(), nullable=False),
        sa.Column("recorded_at", sa.String(), nullable=False),
    )


def downgrade() -> None:
    op.drop_table("numbers")
    op.drop_column("worlds", "numbers_version")
