"""the workflow that plans a goal"""

import sqlalchemy as sa
from alembic import op

revision = "0041"
down_revision = "0040"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("goals", sa.Column("planned_by", sa.String(), nullable=True))


def downgrade() -> None:
    op.drop_column("goals", "planned_by")
