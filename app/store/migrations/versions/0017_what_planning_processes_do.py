"""what an executor's planning processes do"""

import sqlalchemy as sa
from alembic import op

revision = "0017"
down_revision = "0016"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("executors", schema=None) as batch_op:
        batch_op.add_column(sa.Column("planning", sa.JSON(), nullable=True))


def downgrade() -> None:
    with op.batch_alter_table("executors", schema=None) as batch_op:
        batch_op.drop_column("planning")
