"""runs that the service announces itself"""

import sqlalchemy as sa
from alembic import op

revision = "0029"
down_revision = "0028"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("worlds", sa.Column("announced_run", sa.String(length=64), nullable=True))
    op.add_column("worlds", sa.Column("announced_from", sa.Double(), nullable=True))


def downgrade() -> None:
    op.drop_column("worlds", "announced_from")
    op.drop_column("worlds", "announced_run")
