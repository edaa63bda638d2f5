"""What robots do for their own sake, in the record: where they are afterwards is believed."""

from sqlalchemy.orm import Session

from app.core import Core
from app.world_model import reconciled
from app.world_model.beliefs import ROBOT_POSITION
from robots.wire import UpkeepReport


def note_upkeep(session: Session, core: Core, *, world: str, robot: str, report: UpkeepReport) -> None:
    """Believe what the robot perceives, unless something newer is known of where it is."""
    core.facts.lock(session, world)
    rows = core.facts.rows(session, world)
    known_s = max(
        (row.at_s for row in rows if row.predicate == ROBOT_POSITION and row.args[0] == robot), default=0.0
    )
    if report.at_s >= known_s:
        facts = core.facts.facts(session, world)
        change = reconciled(facts, robot, report.perceived, core.knowledge_base)
        core.facts.change(
            session,
            world,
            add=change.add,
            remove=change.remove,
            source=f"report of {robot}",
            at_s=report.at_s,
        )
    data = {"packet": report.tag, "at_s": report.at_s, "detail": report.detail}
    core.events.append(session, f"upkeep.{report.state.value}", robot, world=world, **data)
