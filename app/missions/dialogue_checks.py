"""What stands against a person's request to a robot now, in words."""

from collections.abc import Collection, Iterator, Sequence
from itertools import chain

from sqlalchemy import select
from sqlalchemy.orm import Session

from app.agents.robot_directory import RobotReport
from app.core import Core
from app.domain.contact import Connection
from app.domain.goal_language.words import joined
from app.domain.lifecycles.dialogue import UNDER_WAY
from app.store import ConversationRow, DialogueRow
from app.store.standing_holds import standing_holds
from robots.social.persons import HALT
from robots.wire import BehaviourPacket
from robots.world import WorldFile


def why_not_now(
    session: Session,
    core: Core,
    world: WorldFile,
    report: RobotReport,
    packets: Sequence[BehaviourPacket],
    *,
    filled: Collection[str],
    dialogue: str,
) -> str:
    """The first reason against it; empty if there is none. The robot itself may have others.

    :param filled: places into which the packets put something. :param dialogue: the one in which it is asked.
    """
    busy = _busy(session, report, dialogue)
    taken = _taken(session, core, world, packets)
    return next(
        chain(_unfit(report), busy, taken, _held(session, world, report.view.name, packets, filled)), ""
    )


def _unfit(report: RobotReport) -> Iterator[str]:
    name = report.view.name
    telemetry = report.view.telemetry
    if report.lost is not None:
        yield f"{name} was declared lost; declare it found first"
    if report.out_of_service is not None:
        yield f"{name} is out of service: {report.out_of_service.reason}"
    if report.mission_id is not None:
        yield f"{name} is on mission {report.mission_id}; say it once that has ended, or cancel the mission"
    if report.connection is not Connection.ONLINE:
        yield f"{name} is not in contact: {report.connection}"
    if telemetry is not None and telemetry.driven_by is not None:
        yield f"{telemetry.driven_by} drives {name}"


def _busy(session: Session, report: RobotReport, dialogue: str) -> Iterator[str]:
    """Other requests of persons that the robot is at, and orders to stop on their way."""
    name = report.view.name
    under_way = (DialogueRow.robot == name, DialogueRow.state.in_(UNDER_WAY), DialogueRow.id != dialogue)
    for row in session.scalars(select(DialogueRow).where(*under_way)):
        if row.packets:
            yield f"{name} is at {row.text!r}, as {row.said_by} has asked; say stop first"
    unanswered = (
        ConversationRow.world == report.view.world,
        ConversationRow.robot == name,
        ConversationRow.is_over.is_(False),
    )
    for said in session.scalars(select(ConversationRow.said).where(*unanswered)):
        if said[0]["content"] == HALT:
            # Heard late, it would end what is asked for now.
            yield f"{name} has not answered stop yet; say it again then"


def _taken(
    session: Session, core: Core, world: WorldFile, packets: Sequence[BehaviourPacket]
) -> Iterator[str]:
    """What running missions need of that which the packets name: places, samples, zones for one robot."""
    named = {value for packet in packets for value in packet.arguments.values()}
    for zone in world.zones:
        if any(zone.contains(place.at) for place in world.places if place.name in named):
            named.add(zone.name)
    for mission in core.reservations.of_world(session, world.name):
        if shared := sorted(named & mission.reservation.names):
            yield f"mission {mission.mission_id} needs {joined(shared, last='and')}"


def _held(
    session: Session,
    world: WorldFile,
    robot: str,
    packets: Sequence[BehaviourPacket],
    filled: Collection[str],
) -> Iterator[str]:
    """The holds that keep a place empty into which something would be put, or the robot or a sample where it is."""
    named = (
        {robot, *(value for packet in packets for value in packet.arguments.values())} if packets else set()
    )
    for hold in standing_holds(session, world.name):
        kept = hold.required_of((), world)
        if shared := sorted(kept.kept_empty.intersection(filled)):
            yield f"{joined(shared, last='and')} is kept empty: {hold.words}"
        if shared := sorted((kept.excluded | kept.kept_samples) & named):
            yield f"{joined(shared, last='and')} is kept where it is: {hold.words}"
        if shared := sorted(kept.kept_for.intersection(filled)):
            yield f"{joined(shared, last='and')} is kept for another sample: {hold.words}"
