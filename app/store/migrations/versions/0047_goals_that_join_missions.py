"""missions that carry out other goals beside their own"""

import sqlalchemy as sa
from alembic import op

revision = "0047"
down_revision = "0046"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("missions", sa.Column("joined_goals", sa.JSON(), nullable=False, server_default="[]"))
    joined = sa.text(
        "SELECT m.id, g.id FROM goals g JOIN goals j ON j.id = g.joint_goal JOIN missions m ON m.id = j.mission_id "
        "ORDER BY g.created_at, g.id"
    )
    connection = op.get_bind()
    goals: dict[str, list[str]] = {}
    for mission, goal in connection.execute(joined):
        goals.setdefault(mission, []).append(goal)
    missions = sa.table("missions", sa.column("id"), sa.column("joined_goals", sa.JSON()))
    for mission, ids in goals.items():
        connection.execute(missions.update().where(missions.c.id == mission).values(joined_goals=ids))


def downgrade() -> None:
    op.drop_column("missions", "joined_goals")
