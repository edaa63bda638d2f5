"""tenders of goals"""

import sqlalchemy as sa
from alembic import op

revision = "0038"
down_revision = "0037"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("goals", sa.Column("allocation", sa.String(), nullable=False, server_default="central"))
    op.add_column("goals", sa.Column("tender", sa.JSON(), nullable=True))


def downgrade() -> None:
    op.drop_column("goals", "tender")
    op.drop_column("goals", "allocation")
