"""counters of robots' signed messages"""

import sqlalchemy as sa
from alembic import op

revision = "0034"
down_revision = "0033"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "signature_counters",
        sa.Column("topic", sa.String(length=300), primary_key=True),
        sa.Column("world", sa.String(length=64), nullable=False, index=True),
        sa.Column("key_id", sa.String(length=64), nullable=False),
        sa.Column("before", sa.String(length=32), nullable=False),
        sa.Column("last", sa.String(length=32), nullable=False),
        sa.Column("signature", sa.String(length=64), nullable=False),
    )


def downgrade() -> None:
    op.drop_table("signature_counters")
