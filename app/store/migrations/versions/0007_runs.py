"""runs of worlds"""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("worlds", sa.Column("run", sa.String(length=64), nullable=True))


def downgrade() -> None:
    op.drop_column("worlds", "run")
