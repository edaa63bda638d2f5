"""clearances"""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("scripts", schema=None) as batch_op:
        batch_op.add_column(sa.Column("cleared", sa.JSON(), nullable=False, server_default="[]"))
        batch_op.add_column(sa.Column("clearance", sa.String(), nullable=True))


def downgrade() -> None:
    with op.batch_alter_table("scripts", schema=None) as batch_op:
        batch_op.drop_column("clearance")
        batch_op.drop_column("cleared")
