"""factsheets of robots"""

import sqlalchemy as sa
from alembic import op

revision = "0027"
down_revision = "0026"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "factsheets",
        sa.Column("world", sa.String(length=64), sa.ForeignKey("worlds.id"), primary_key=True),
        sa.Column("robot", sa.String(length=64), primary_key=True),
        sa.Column("run", sa.String(length=64), nullable=False),
        sa.Column("message_id", sa.String(length=120), nullable=False),
        sa.Column("number", sa.BigInteger(), nullable=False),
        sa.Column("sheet", sa.JSON(), nullable=False),
        sa.Column("state", sa.String(), nullable=False),
        sa.Column("reason", sa.String(), nullable=False),
        sa.Column("edition", sa.Integer()),
        sa.Column("decided_by", sa.String()),
        sa.Column("is_told", sa.Boolean(), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.Column("came_at", sa.String(), nullable=False),
    )


def downgrade() -> None:
    op.drop_table("factsheets")
