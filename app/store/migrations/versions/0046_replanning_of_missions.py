"""missions whose operators ask for another plan"""

import sqlalchemy as sa
from alembic import op

revision = "0046"
down_revision = "0045"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("missions", sa.Column("replanning", sa.JSON()))


def downgrade() -> None:
    op.drop_column("missions", "replanning")
