"""roles"""

import sqlalchemy as sa
from alembic import op

revision = "0035"
down_revision = "0034"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "roles",
        sa.Column("world", sa.String(length=64), sa.ForeignKey("worlds.id"), primary_key=True),
        sa.Column("robot", sa.String(length=64), primary_key=True),
        sa.Column("version", sa.Integer(), nullable=False),
        sa.Column("role", sa.String(), nullable=False),
        sa.Column("tags", sa.JSON(), nullable=True),
        sa.Column("home", sa.String(), nullable=True),
        sa.Column("former_home", sa.String(), nullable=True),
        sa.Column("rules", sa.String(), nullable=True),
        sa.Column("comment", sa.String(), nullable=False),
        sa.Column("decided_by", sa.String(), nullable=True),
        sa.Column("decided_at", sa.String(), nullable=True),
    )
    with op.batch_alter_table("rules") as table:
        table.add_column(sa.Column("role", sa.String(), nullable=False, server_default=""))
        table.add_column(sa.Column("role_files", sa.JSON(), nullable=False, server_default="[]"))
        table.add_column(sa.Column("played", sa.String(), nullable=False, server_default=""))


def downgrade() -> None:
    with op.batch_alter_table("rules") as table:
        table.drop_column("played")
        table.drop_column("role_files")
        table.drop_column("role")
    op.drop_table("roles")
