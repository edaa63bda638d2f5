"""deletion of goals: indexes for the rows that refer to them"""

from alembic import op

revision = "0011"
down_revision = "0010"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_index("ix_missions_goal_id", "missions", ["goal_id"])
    op.create_index("ix_scripts_plan_id", "scripts", ["plan_id"])


def downgrade() -> None:
    op.drop_index("ix_scripts_plan_id", "scripts")
    op.drop_index("ix_missions_goal_id", "missions")
