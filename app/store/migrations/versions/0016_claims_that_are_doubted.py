"""when scripts were given to their robots, and why a robot's report on one is implausible"""

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("scripts", schema=None) as batch_op:
        batch_op.add_column(sa.Column("given_at_s", sa.Double(), nullable=True))
        batch_op.add_column(sa.Column("doubt", sa.String(), nullable=False, server_default=""))


def downgrade() -> None:
    with op.batch_alter_table("scripts", schema=None) as batch_op:
        batch_op.drop_column("doubt")
        batch_op.drop_column("given_at_s")
