"""messages known by their robot and id"""

from alembic import op

revision = "0031"
down_revision = "0030"
branch_labels = None
depends_on = None

LONGEST = 120
"""Longer keys are digests; what is repeated under one of them after an update is recorded again."""


def upgrade() -> None:
    op.execute(f"UPDATE messages SET id = robot || '/' || id WHERE length(robot) + length(id) < {LONGEST}")


def downgrade() -> None:
    op.execute("UPDATE messages SET id = substr(id, length(robot) + 2) WHERE id LIKE robot || '/%'")
