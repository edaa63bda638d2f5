"""missions that would end sooner if they were planned again"""

import sqlalchemy as sa
from alembic import op

revision = "0048"
down_revision = "0047"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("missions", sa.Column("better_plan", sa.JSON()))


def downgrade() -> None:
    op.drop_column("missions", "better_plan")
