"""recovery"""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("goals", schema=None) as batch_op:
        batch_op.add_column(sa.Column("recovery", sa.String(), nullable=False, server_default="never"))
    with op.batch_alter_table("missions", schema=None) as batch_op:
        batch_op.add_column(sa.Column("revision", sa.Integer(), nullable=False, server_default="1"))
        batch_op.add_column(sa.Column("revised_at_s", sa.Double(), nullable=True))
        batch_op.add_column(sa.Column("stopped_for", sa.String(), nullable=False, server_default=""))
        batch_op.add_column(sa.Column("recovery", sa.String(), nullable=False, server_default="never"))
        batch_op.add_column(sa.Column("recovery_step", sa.String(), nullable=True))
        batch_op.add_column(sa.Column("tries_left", sa.Integer(), nullable=False, server_default="0"))
        batch_op.add_column(sa.Column("attempts", sa.JSON(), nullable=False, server_default="[]"))
    with op.batch_alter_table("scripts", schema=None) as batch_op:
        batch_op.add_column(sa.Column("plan_id", sa.String(length=120), nullable=True))
        batch_op.add_column(sa.Column("abandoned", sa.Boolean(), nullable=False, server_default=sa.false()))
    op.execute(
        "UPDATE scripts SET plan_id = (SELECT plan_id FROM missions WHERE missions.id = scripts.mission_id)"
    )
    with op.batch_alter_table("scripts", schema=None) as batch_op:
        batch_op.alter_column("plan_id", existing_type=sa.String(length=120), nullable=False)
        batch_op.create_foreign_key("fk_scripts_plan_id", "plans", ["plan_id"], ["id"])


def downgrade() -> None:
    with op.batch_alter_table("scripts", schema=None) as batch_op:
        batch_op.drop_constraint("fk_scripts_plan_id", type_="foreignkey")
        batch_op.drop_column("abandoned")
        batch_op.drop_column("plan_id")
    with op.batch_alter_table("missions", schema=None) as batch_op:
        for name in ("attempts", "tries_left", "recovery_step", "recovery"):
            batch_op.drop_column(name)
        for name in ("stopped_for", "revised_at_s", "revision"):
            batch_op.drop_column(name)
    with op.batch_alter_table("goals", schema=None) as batch_op:
        batch_op.drop_column("recovery")
