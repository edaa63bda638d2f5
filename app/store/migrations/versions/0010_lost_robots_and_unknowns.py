"""lost robots, unknowns, contradicted facts"""

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "lost_robots",
        sa.Column("world", sa.String(length=64), sa.ForeignKey("worlds.id"), primary_key=True),
        sa.Column("robot", sa.String(length=64), primary_key=True),
        sa.Column("silent", sa.Boolean(), nullable=False),
        sa.Column("since_s", sa.Double(), nullable=False),
        sa.Column("declared_by", sa.String(), nullable=False),
        sa.Column("comment", sa.String(), nullable=False),
        sa.Column("declared_at", sa.String(), nullable=False),
    )
    op.create_table(
        "unknowns",
        sa.Column("world", sa.String(length=64), sa.ForeignKey("worlds.id"), primary_key=True),
        sa.Column("name", sa.String(length=64), primary_key=True),
        sa.Column("believed", sa.JSON(), nullable=False),
        sa.Column("believed_by", sa.String(), nullable=False),
        sa.Column("believed_at_s", sa.Double(), nullable=False),
        sa.Column("source", sa.String(), nullable=False),
        sa.Column("since_s", sa.Double(), nullable=False),
    )
    with op.batch_alter_table("facts", schema=None) as batch_op:
        batch_op.add_column(sa.Column("instead_of", sa.JSON(), nullable=False, server_default="[]"))


def downgrade() -> None:
    with op.batch_alter_table("facts", schema=None) as batch_op:
        batch_op.drop_column("instead_of")
    op.drop_table("unknowns")
    op.drop_table("lost_robots")
