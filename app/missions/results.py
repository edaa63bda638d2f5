"""What packets bring beside their effects, kept with the mission: images and readings."""

import logging

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.core import Core
from app.domain.errors import Invalid
from app.domain.events import ResultReceived
from app.domain.ids import new_id
from app.domain.world_model.numbers import check_term, check_value
from app.store import MissionRow, ResultRow, ScriptRow
from app.store.facts import source_of
from robots.wire import ImageResult, PacketReport, PacketState, ReadingResult

logger = logging.getLogger(__name__)


def keep_results(
    session: Session, core: Core, report: PacketReport, script: ScriptRow, mission: MissionRow
) -> None:
    """Record the results of a finished packet's first report, each with its event; readings become numeric facts.

    A robot that resumes from a snapshot may end a packet again, and report other results of it: they do not count.
    """
    if report.state is not PacketState.FINISHED or not report.results:
        return
    known = select(ResultRow.id).where(
        ResultRow.script_id == script.id, ResultRow.packet_id == report.packet_id
    )
    if session.scalar(known.limit(1)) is not None:
        return
    events = core.events
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
            _note_reading(session, core, result, script.robot, mission.world, report.at_s)
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


def _note_reading(
    session: Session, core: Core, reading: ReadingResult, robot: str, world: str, at_s: float
) -> None:
    """Give the numeric fact that a reading tells of its value, unless a newer one is known.

    A reading that the knowledge base does not know as a quantity, or that cannot be one, is a result and nothing more.
    """
    base = core.knowledge_base
    try:
        term = check_term(reading.name, (reading.of,), core.facts.numbers.things(session, world), base)
        check_value(reading.name, reading.value, base)
    except Invalid as error:
        if reading.name in base.quantities:
            logger.warning("reading of %s ignored: %s", robot, error)
        return
    unit = base.quantities[reading.name].unit
    if reading.unit and unit and reading.unit != unit:
        logger.warning("reading of %s ignored: %s is in %s, not %s", robot, reading.name, unit, reading.unit)
        return
    values = {term: reading.value}
    core.facts.numbers.set(session, world, values, source=source_of(robot), at_s=at_s, is_told=True)
