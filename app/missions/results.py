"""What packets bring beside their effects, kept with the mission: images and readings."""

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.domain.events import ResultReceived
from app.domain.ids import new_id
from app.store import MissionRow, ResultRow, ScriptRow
from app.store.event_log import EventLog
from robots.wire import ImageResult, PacketReport, PacketState


def keep_results(
    session: Session, events: EventLog, report: PacketReport, script: ScriptRow, mission: MissionRow
) -> None:
    """Record the results of a finished packet's first report, each with its event.

    A robot that resumes from a snapshot may end a packet again, and report other results of it: they do not count.
    """
    if report.state is not PacketState.FINISHED or not report.results:
        return
    known = select(ResultRow.id).where(
        ResultRow.script_id == script.id, ResultRow.packet_id == report.packet_id
    )
    if session.scalar(known.limit(1)) is not None:
        return
    mission.results += len(report.results)
    ids = sorted(new_id("result") for _ in report.results)  # they are listed by time and id
    for result_id, result in zip(ids, report.results, strict=True):
        row = ResultRow(
            id=result_id,
            mission_id=mission.id,
            script_id=script.id,
            packet_id=report.packet_id,
            robot=script.robot,
            kind=result.kind,
            name=result.name,
            of=result.of,
            at_s=report.at_s,
        )
        if isinstance(result, ImageResult):
            row.media_type = result.media_type
            row.content = result.data
            row.size_bytes = len(result.data)
        else:
            row.value = result.value
            row.unit = result.unit
        session.add(row)
        events.append(
            session,
            ResultReceived(
                subject=mission.id,
                result=row.id,
                robot=script.robot,
                packet=report.packet_id,
                at_s=report.at_s,
                kind=result.kind,
                name=result.name,
                of=result.of,
                value=row.value,
                unit=row.unit or "",
            ),
        )
