"""orders on scripts as verb and number; whether a mission is overdue"""

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"
branch_labels = None
depends_on = None

OVERDUE = "its deadline has passed"
"""What the reasons of overdue missions ended with."""
ENDED = ("completed", "partially_completed", "failed", "cancelled")

missions = sa.table(
    "missions",
    sa.column("id"),
    sa.column("state"),
    sa.column("reason"),
    sa.column("is_overdue", sa.Boolean()),
)
scripts = sa.table(
    "scripts", sa.column("id"), sa.column("control"), sa.column("control_number", sa.Integer())
)


def upgrade() -> None:
    with op.batch_alter_table("missions", schema=None) as batch_op:
        # A constant: for an expression SQLite would need to recreate the table, which the scripts refer to.
        batch_op.add_column(sa.Column("is_overdue", sa.Boolean(), nullable=False, server_default="0"))
    with op.batch_alter_table("scripts", schema=None) as batch_op:
        batch_op.add_column(sa.Column("control_number", sa.Integer(), nullable=True))
    connection = op.get_bind()
    overdue = sa.select(missions.c.id, missions.c.reason).where(
        missions.c.reason.endswith(OVERDUE), missions.c.state.not_in(ENDED)
    )
    for mission_id, reason in connection.execute(overdue).all():
        news = {"is_overdue": True, "reason": reason.removesuffix(OVERDUE).removesuffix("; ")}
        connection.execute(sa.update(missions).where(missions.c.id == mission_id).values(news))
    ordered = sa.select(scripts.c.id, scripts.c.control).where(scripts.c.control.is_not(None))
    for script_id, control in connection.execute(ordered).all():
        verb, _, number = control.partition(":")
        news = {"control": verb, "control_number": int(number)}
        connection.execute(sa.update(scripts).where(scripts.c.id == script_id).values(news))


def downgrade() -> None:
    connection = op.get_bind()
    order = scripts.c.control + ":" + sa.cast(scripts.c.control_number, sa.String())
    connection.execute(sa.update(scripts).where(scripts.c.control.is_not(None)).values(control=order))
    with op.batch_alter_table("scripts", schema=None) as batch_op:
        batch_op.drop_column("control_number")
    with op.batch_alter_table("missions", schema=None) as batch_op:
        batch_op.drop_column("is_overdue")
