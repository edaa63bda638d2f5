"""minds that are handed over between programs"""

import sqlalchemy as sa
from alembic import op

revision = "0042"
down_revision = "0041"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("embodiments", sa.Column("mind", sa.JSON(), nullable=True))
    op.add_column("embodiments", sa.Column("taken", sa.Integer(), nullable=False, server_default="0"))
    op.add_column("embodiments", sa.Column("asked_s", sa.Double(), nullable=True))


def downgrade() -> None:
    for column in ("asked_s", "taken", "mind"):
        op.drop_column("embodiments", column)
