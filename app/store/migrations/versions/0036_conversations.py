"""conversations of the service with robots"""

import sqlalchemy as sa
from alembic import op

revision = "0036"
down_revision = "0035"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "conversations",
        sa.Column("id", sa.String(length=120), primary_key=True),
        sa.Column("robot", sa.String(length=64), primary_key=True),
        sa.Column("world", sa.String(length=64), nullable=False),
        sa.Column("protocol", sa.String(length=64), nullable=False),
        sa.Column("is_ours", sa.Boolean(), nullable=False),
        sa.Column("state", sa.String(), nullable=False),
        sa.Column("is_over", sa.Boolean(), nullable=False),
        sa.Column("is_due", sa.Boolean(), nullable=False),
        sa.Column("reason", sa.String(), nullable=False),
        sa.Column("opener", sa.String(), nullable=False),
        sa.Column("about", sa.String(length=120), nullable=False),
        sa.Column("speaker", sa.String(), nullable=False),
        sa.Column("said", sa.JSON(), nullable=False),
        sa.Column("reply_by_s", sa.Double(), nullable=True),
        sa.Column("opened_at", sa.String(), nullable=False),
    )
    op.create_index("ix_conversations_open", "conversations", ["world", "is_over"])
    op.create_index("ix_conversations_robot", "conversations", ["world", "robot", "opened_at"])


def downgrade() -> None:
    op.drop_table("conversations")
