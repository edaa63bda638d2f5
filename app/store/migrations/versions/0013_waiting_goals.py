"""goals that wait have a state of their own"""

from alembic import op

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None


def upgrade() -> None:
    # A goal whose plan has expired is submitted again with a reason, too; a workflow to plan it is queued already.
    op.execute(
        "UPDATE goals SET state = 'waiting' "
        "WHERE state = 'submitted' AND reason <> '' AND reason NOT LIKE 'the plan was overtaken:%'"
    )


def downgrade() -> None:
    op.execute("UPDATE goals SET state = 'submitted' WHERE state = 'waiting'")
