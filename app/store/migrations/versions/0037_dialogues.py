"""dialogues of persons with robots"""

import sqlalchemy as sa
from alembic import op

revision = "0037"
down_revision = "0036"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "dialogues",
        sa.Column("id", sa.String(length=120), primary_key=True),
        sa.Column("world", sa.String(length=64), nullable=False),
        sa.Column("robot", sa.String(length=64), nullable=False),
        sa.Column("state", sa.String(), nullable=False),
        sa.Column("reason", sa.String(), nullable=False),
        sa.Column("text", sa.String(), nullable=False),
        sa.Column("asked", sa.JSON(), nullable=False),
        sa.Column("packets", sa.JSON(), nullable=False),
        sa.Column("lines", sa.JSON(), nullable=False),
        sa.Column("conversation", sa.String(length=120), nullable=False),
        sa.Column("said_by", sa.String(), nullable=False),
        sa.Column("idempotency_key", sa.String(length=200), nullable=True, unique=True),
        sa.Column("created_at", sa.String(), nullable=False),
    )
    op.create_index("ix_dialogues_newest", "dialogues", ["robot", "created_at", "id"])
    op.create_index("ix_dialogues_conversation", "dialogues", ["conversation"])


def downgrade() -> None:
    op.drop_table("dialogues")
