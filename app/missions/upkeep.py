"""What robots do that no mission asked for, in the record: where they are afterwards is believed."""

from sqlalchemy.orm import Session

from app.core import Core
from app.domain.events import TeleoperationBegan, TeleoperationEnded, UpkeepReported
from app.domain.world_model import reconcile_report
from app.domain.world_model.beliefs import ROBOT_POSITION
from app.domain.world_model.timeliness import newer_subjects, without_outdated
from app.store.facts import source_of
from app.workflows.mission_wakeups import wake_missions
from robots.wire import PacketState, UpkeepReport


def note_upkeep(session: Session, core: Core, *, world: str, robot: str, report: UpkeepReport) -> None:
    """Believe what the robot perceives, unless something newer is known of where it is, or of what it sees."""
    core.facts.lock(session, world)
    rows = core.facts.rows(session, world)
    known_s = max(
        (row.at_s for row in rows if row.predicate == ROBOT_POSITION and row.args[0] == robot), default=0.0
    )
    if report.at_s >= known_s:
        facts, before = core.facts.facts(session, world), core.facts.version(session, world)
        newer = newer_subjects(core.facts.dated(session, world), report.at_s)
        change = without_outdated(
            facts, reconcile_report(facts, robot, report.perceived, core.knowledge_base), newer
        )
        version = core.facts.change(
            session,
            world,
            add=change.add,
            remove=change.remove,
            source=source_of(robot),
            at_s=report.at_s,
            corrects=True,
        )
        if version != before:
            wake_missions(session, core.workflows, world, f"facts:{version}")
    if report.driver is None:
        upkeep = UpkeepReported(
            subject=robot,
            world=world,
            packet=report.tag,
            state=report.state,
            at_s=report.at_s,
            detail=report.detail,
        )
        core.events.append(session, upkeep)
    elif report.state is not PacketState.RUNNING or not report.detail:  # else it is news on the way
        drive = TeleoperationBegan if report.state is PacketState.RUNNING else TeleoperationEnded
        core.events.append(
            session,
            drive(
                subject=robot,
                world=world,
                driver=report.driver,
                packet=report.tag,
                at_s=report.at_s,
                detail=report.detail,
            ),
        )
