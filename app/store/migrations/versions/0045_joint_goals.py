"""goals that are carried out together with others"""

import sqlalchemy as sa
from alembic import op

revision = "0045"
down_revision = "0044"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("goals", sa.Column("joint_goal", sa.String(120)))


def downgrade() -> None:
    op.drop_column("goals", "joint_goal")
