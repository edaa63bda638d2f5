"""Agent models: they deliver scripts and all that concerns them until a robot answers, and record what robots report.

The record says what is still to be delivered, so a restart forgets nothing; a message keeps its id however often it is
sent, so a robot acts on it once.
"""

import logging
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from sqlalchemy import or_, select

from app.agents.pace import LEAST_S, Pace
from app.agents.questions import Questions
from app.agents.robot_board import RobotBoard
from app.agents.teleoperation import Teleoperation
from app.agents.tuning import TuningService
from app.domain.lifecycles.mission import ENDED, MissionState
from app.domain.lifecycles.script import Delivery, order_label, unanswered_order
from app.store import Database, MissionRow, ScriptRow, is_away
from app.workflows.background import Background
from robots.clock import Clock
from robots.link import Link, LinkClosed
from robots.wire import (
    BehaviourScript,
    Body,
    Clearance,
    ControlVerb,
    Message,
    Performative,
    Receipt,
    Retune,
    ScriptRequest,
    StatusQuery,
    Telemetry,
    TuningReport,
)
from robots.world import LinkSpec

SERVICE = "service"
LISTEN_S = 0.05
LOOK_S = 1.0
"""Wall-clock seconds after which the record is looked at again, though nothing is outstanding."""

logger = logging.getLogger(__name__)


class ReportRecorder(Protocol):
    """Records what robots report of their scripts, with all its consequences."""

    def record(self, message: Message, world: str) -> bool:
        """Record a report once; False if it is known already or concerns no known script."""
        ...


class AgentModels:
    """The agent models of one world's robots, on one link, in one thread."""

    def __init__(
        self,
        *,
        robots: Mapping[str, LinkSpec],
        link: Link,
        clock: Clock,
        database: Database,
        reports: ReportRecorder,
        board: RobotBoard,
        questions: Questions,
        teleoperation: Teleoperation,
        tunings: TuningService,
        welcome: Callable[[], None],
        world: str,
        speaks: Callable[[], bool] = lambda: True,
        between: Callable[[], None] = lambda: None,
    ) -> None:
        """
        :param robots: each with its radio.
        :param welcome: takes back robots that were given up as silent and are heard again.
        :param speaks: True while this process, of those that share the record, delivers and records. While it does
            not it listens, for what robots say of themselves now, and asks what its own clients ask.
        :param between: what else is to be seen to for the world, called again and again; before any message.
        """
        self._speaks, self._between = speaks, between
        self._robots, self._link, self._clock, self._world = frozenset(robots), link, clock, world
        self._pace = Pace(clock, robots, heard_s=lambda robot: board.view(robot).heard_s)
        self._database, self._reports, self._board = database, reports, board
        self._questions, self._tunings, self._welcome = questions, tunings, welcome
        self._teleoperation = teleoperation
        self._outstanding: set[str] = set()
        self._due = threading.Event()
        self._background = Background(f"agents-{world}", self._run)
        database.committed.append(self._due.set)

    def start(self) -> None:
        self._background.start()

    def close(self) -> None:
        self._background.end()

    def _run(self) -> None:
        due_at = 0.0
        while not self._background.ending.is_set():
            try:
                self._between()
                for message in self._link.receive(LISTEN_S):
                    self._take(message)
                self._ask()
                if self._due.is_set() or time.monotonic() >= due_at:
                    self._due.clear()
                    if self._speaks():
                        self._welcome()
                        self._deliver()
                    due_at = time.monotonic() + (LEAST_S if self._pace.outstanding else LOOK_S)
            except LinkClosed:
                logger.warning("the link to the robots of %s is closed", self._world)
                self._board.broke(self._world)
                return
            except Exception as error:
                # One message that cannot be recorded now (the database is away, say) must not end the listening:
                # robots keep their reports until they get a receipt, so it comes again.
                if is_away(error):
                    logger.warning("agent models of %s wait for the database", self._world)
                else:
                    logger.exception("agent models of %s: a message could not be handled", self._world)
                self._background.ending.wait(LOOK_S)

    def _take(self, message: Message) -> None:
        if message.sender not in self._robots:
            return
        if isinstance(message.body, Telemetry):
            self._board.heard(message.sender, message.body)
            return
        self._board.heard(message.sender)
        here = self._questions.answered(message) or self._teleoperation.refused(message)
        if here or not self._speaks():
            return
        if isinstance(message.body, TuningReport):
            self._tunings.answered(self._world, message.sender, message.performative, message.body)
            return
        self._reports.record(message, self._world)
        if message.performative in (Performative.INFORM, Performative.FAILURE):
            self._send(message.sender, Performative.CONFIRM, Receipt(), in_reply_to=message.id)

    def _ask(self) -> None:
        """Pass on what clients ask and wish right now, once: they do not wait long."""
        for question in self._questions.to_send(self._robots):
            self._send(question.robot, Performative.QUERY, question.body, message_id=question.id)
        for robot, set_point in self._teleoperation.to_send(self._robots):
            self._send(robot, Performative.REQUEST, set_point)

    def _deliver(self) -> None:
        """Send what the record says is not answered yet, as far as it is due."""
        self._outstanding.clear()
        for row in self._tunings.pending(self._world):
            retune = Retune(version=row.version, tuning=row.tuning)
            self._repeat(row.robot, f"{row.robot}:tuning:{row.version}", Performative.REQUEST, retune)
        for script in self._open_scripts():
            if script.delivery == Delivery.PENDING and not script.stopping:
                body = BehaviourScript.model_validate(script.body)
                self._repeat(
                    script.robot, f"{script.id}:request", Performative.REQUEST, ScriptRequest(script=body)
                )
                continue
            if script.clearance is not None:
                clearance = Clearance(script_id=script.id, ended=tuple(script.cleared))
                self._repeat(script.robot, f"{script.id}:{script.clearance}", Performative.REQUEST, clearance)
            if (order := unanswered_order(script)) is not None:
                cancels = order.verb is ControlVerb.CANCEL
                performative = Performative.CANCEL if cancels else Performative.REQUEST
                self._repeat(script.robot, f"{script.id}:{order_label(order)}", performative, order)
            elif script.question is not None:
                query = StatusQuery(script_id=script.id)
                self._repeat(script.robot, script.question, Performative.QUERY, query)
        self._pace.keep(self._outstanding)

    def _open_scripts(self) -> Sequence[ScriptRow]:
        unanswered = or_(
            ScriptRow.delivery == Delivery.PENDING,
            ScriptRow.clearance.is_not(None),
            ScriptRow.control.is_not(None),
            ScriptRow.question.is_not(None),
        )
        query = (
            select(ScriptRow, MissionRow.state)
            .join(MissionRow, MissionRow.id == ScriptRow.mission_id)
            .where(
                MissionRow.world == self._world,
                or_(MissionRow.state.not_in(ENDED), ScriptRow.abandoned),
                ScriptRow.robot.in_(self._robots),
                unanswered,
            )
            .order_by(ScriptRow.id)
        )
        with self._database.read() as session:
            found = session.execute(query).all()
        return [
            row
            for row, state in found
            if state != MissionState.PAUSED or row.delivery != Delivery.PENDING or row.stopping
        ]

    def _repeat(self, robot: str, message_id: str, performative: Performative, body: Body) -> None:
        self._outstanding.add(message_id)
        if self._pace.is_due(robot, message_id):
            self._send(robot, performative, body, message_id=message_id)

    def _send(
        self,
        robot: str,
        performative: Performative,
        body: Body,
        *,
        message_id: str | None = None,
        in_reply_to: str | None = None,
    ) -> None:
        named = {"id": message_id} if message_id else {}
        self._link.send(
            Message(
                **named,
                performative=performative,
                sender=SERVICE,
                receiver=robot,
                sent_at_s=self._clock.now_s(),
                in_reply_to=in_reply_to,
                body=body,
            )
        )
