"""workflows that are to plan waiting goals"""

import sqlalchemy as sa
from alembic import op

revision = "0044"
down_revision = "0043"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("worlds", sa.Column("waiting_workflow", sa.String(64)))


def downgrade() -> None:
    op.drop_column("worlds", "waiting_workflow")
