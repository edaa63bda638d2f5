"""What the event log tells of states, beside the states of the record."""

from sqlalchemy import select

from app.store import Database, EventRow, GoalRow, MissionRow, PlanRow

States = dict[str, str]
SUBJECTS = ("goal", "plan", "mission")


def states_told(rows: list[EventRow]) -> States:
    """The last state that events of goals, plans and missions tell, by the subject's id."""
    return {row.subject: row.data["state"] for row in rows if row.type.partition(".")[0] in SUBJECTS}


def told_and_recorded(database: Database) -> tuple[States, States]:
    """The states that the events tell, and those of the rows, both of one instant."""
    with database.read() as session:
        # PostgreSQL else shows each query what is committed by then.
        if database.engine.dialect.name == "postgresql":
            session.connection(execution_options={"isolation_level": "REPEATABLE READ"})
        told = states_told(list(session.scalars(select(EventRow).order_by(EventRow.seq))))
        recorded: States = {}
        for table in (GoalRow, PlanRow, MissionRow):
            recorded |= {row.id: row.state for row in session.scalars(select(table))}
    return told, recorded
