"""results of missions"""

import sqlalchemy as sa
from alembic import op

revision = "0021"
down_revision = "0020"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "results",
        sa.Column("id", sa.String(length=120), primary_key=True),
        sa.Column("mission_id", sa.String(length=120), sa.ForeignKey("missions.id"), nullable=False),
        sa.Column("script_id", sa.String(length=120), sa.ForeignKey("scripts.id"), nullable=False),
        sa.Column("packet_id", sa.String(), nullable=False),
        sa.Column("robot", sa.String(), nullable=False),
        sa.Column("kind", sa.String(), nullable=False),
        sa.Column("name", sa.String(), nullable=False),
        sa.Column("of", sa.String(), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.Column("media_type", sa.String(), nullable=True),
        sa.Column("size_bytes", sa.Integer(), nullable=True),
        sa.Column("content", sa.LargeBinary(), nullable=True),
        sa.Column("value", sa.Double(), nullable=True),
        sa.Column("unit", sa.String(), nullable=False),
        sa.Column("created_at", sa.String(), nullable=False),
    )
    op.add_column("missions", sa.Column("results", sa.Integer(), nullable=False, server_default="0"))
    op.create_index("ix_results_mission_id", "results", ["mission_id"])
    op.create_index("ix_results_script_id", "results", ["script_id"])


def downgrade() -> None:
    op.drop_column("missions", "results")
    op.drop_table("results")
