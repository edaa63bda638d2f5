"""facts that holds keep true"""

import sqlalchemy as sa
from alembic import op

revision = "0043"
down_revision = "0042"
branch_labels = None
depends_on = None


def upgrade() -> None:
    for name in ("facts", "achieved", "lost"):
        op.add_column("holds", sa.Column(name, sa.JSON(), nullable=False, server_default="[]"))
    op.add_column("holds", sa.Column("losses", sa.Integer(), nullable=False, server_default="0"))


def downgrade() -> None:
    for column in ("losses", "lost", "achieved", "facts"):
        op.drop_column("holds", column)
