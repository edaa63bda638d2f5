"""Questions to robots whose answers clients wait for. Kept in memory: they do not outlive the client's request."""

import threading
from collections import deque
from collections.abc import Callable, Collection
from concurrent.futures import Future
from concurrent.futures import TimeoutError as TooLate
from dataclasses import dataclass, field

from app.domain.errors import Busy, Conflict, Silent
from robots.wire import Body, Message, MindQuery, MindReport, TraceQuery, TraceReport, new_message_id

MAX_OPEN = 8
"""Questions to one robot that may be open at a time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """A query to a robot, and its answer once it arrives."""

    robot: str
    body: Body
    id: str = field(default_factory=new_message_id)
    answer: "Future[Body]" = field(default_factory=Future)


class Questions:
    """Passes questions to the agent models and answers to the waiting clients. Thread-safe."""

    def __init__(self, *, patience_s: float, why_mute: Callable[[str], str] = lambda robot: "") -> None:
        """
        :param patience_s: wall-clock seconds a robot may take to answer.
        :param why_mute: why a robot cannot answer now, in words; empty: it may.
        """
        self._why_mute = why_mute
        self._patience_s = patience_s
        self._lock = threading.Lock()
        self._unsent: deque[Question] = deque()
        self._open: dict[str, Question] = {}

    def trace(self, robot: str, seconds: float) -> TraceReport:
        """The robot's trace of behaviour synthesis over the last seconds. Blocks until the robot answers.

        :raises Silent: if it does not in time. :raises Conflict: if its world stands.
        :raises Conflict: if it has none: it refuses, or does not understand the question.
        :raises Busy: if `MAX_OPEN` questions to it are open.
        """
        answer = self._ask(Question(robot=robot, body=TraceQuery(seconds=seconds)))
        if not isinstance(answer, TraceReport):
            raise Conflict(f"{robot} keeps no trace", code="no-trace")
        return answer

    def mind(self, robot: str) -> MindReport:
        """What the robot believes and is committed to. Blocks until the robot answers.

        :raises Silent: if it does not in time. :raises Conflict: if its world stands.
        :raises Conflict: if it refuses, or does not understand the question, as robots of older software do not.
        :raises Busy: if `MAX_OPEN` questions to it are open.
        """
        answer = self._ask(Question(robot=robot, body=MindQuery()))
        if not isinstance(answer, MindReport):
            detail = f"{robot} does not tell of its mind: its software does not know the question mind_query"
            raise Conflict(detail, code="no-mind")
        return answer

    def to_send(self, robots: Collection[str]) -> list[Question]:
        """Take the questions to these robots that are not sent yet."""
        with self._lock:
            mine = [one for one in self._unsent if one.robot in robots]
            for one in mine:
                self._unsent.remove(one)
            return mine

    def answered(self, message: Message) -> bool:
        """Pass an answer to the client that waits; True if the message is the answer to a question, also a late one."""
        with self._lock:
            question = self._open.get(message.in_reply_to or "")
            if question is not None and question.robot == message.sender:
                del self._open[question.id]
            else:
                question = None
        if question is not None:
            question.answer.set_result(message.body)
        return question is not None or isinstance(message.body, TraceReport | MindReport)

    def begin_mind(self, robot: str) -> Question | None:
        """Ask for the robot's mind without waiting for `Question.answer`; None if too many questions to it are open."""
        question = Question(robot=robot, body=MindQuery())
        return question if self._open_question(question) else None

    def withdraw(self, question: Question) -> None:
        """Do not await its answer any longer."""
        with self._lock:
            self._open.pop(question.id, None)
            if question in self._unsent:
                self._unsent.remove(question)

    def _open_question(self, question: Question) -> bool:
        with self._lock:
            if sum(one.robot == question.robot for one in self._open.values()) >= MAX_OPEN:
                return False
            self._unsent.append(question)
            self._open[question.id] = question
        return True

    def _ask(self, question: Question) -> Body:
        if why := self._why_mute(question.robot):
            raise Conflict(why, code="world-stands", thing=question.robot)
        if not self._open_question(question):
            detail = f"{MAX_OPEN} questions to {question.robot} are open; ask again when it has answered"
            raise Busy(detail, code="too-many-questions")
        try:
            return question.answer.result(self._patience_s)
        except TooLate:
            detail = f"{question.robot} has not answered within {self._patience_s:g} s; ask again when it is online"
            raise Silent(detail) from None
        finally:
            self.withdraw(question)
