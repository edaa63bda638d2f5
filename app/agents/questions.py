"""Questions to robots that a client waits for the answer to. Kept in memory: nobody asks again after a restart."""

import threading
from collections import deque
from collections.abc import Collection
from concurrent.futures import Future
from concurrent.futures import TimeoutError as TooLate
from dataclasses import dataclass, field

from app.domain.errors import Busy, Silent
from robots.wire import Body, Message, TraceQuery, TraceReport, new_message_id

OPEN_AT_MOST = 8
"""Questions to one robot that may be open at a time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """A query on its way to a robot, and the answer to come."""

    robot: str
    body: Body
    id: str = field(default_factory=new_message_id)
    answer: "Future[Body]" = field(default_factory=Future)


class Questions:
    """Hands questions to the agent models and answers to those who wait for them. Thread-safe."""

    def __init__(self, *, patience_s: float) -> None:
        """:param patience_s: wall-clock seconds a robot may take to answer before it counts as silent."""
        self._patience_s = patience_s
        self._lock = threading.Lock()
        self._unsent: deque[Question] = deque()
        self._open: dict[str, Question] = {}

    def trace(self, robot: str, seconds: float) -> TraceReport:
        """What the robot's synthesis did in the last seconds. Blocks until the robot answers.

        :raises Silent: if it does not in time.
        :raises Busy: if too many questions to it are open.
        """
        answer = self._ask(Question(robot=robot, body=TraceQuery(seconds=seconds)))
        assert isinstance(answer, TraceReport)
        return answer

    def to_send(self, robots: Collection[str]) -> list[Question]:
        """The questions to these robots that are not on their way yet."""
        with self._lock:
            mine = [one for one in self._unsent if one.robot in robots]
            for one in mine:
                self._unsent.remove(one)
            return mine

    def answered(self, message: Message) -> bool:
        """True if the message answers a question that somebody asked here, or gave up waiting for."""
        with self._lock:
            question = self._open.pop(message.in_reply_to or "", None)
        if question is not None:
            question.answer.set_result(message.body)
        return isinstance(message.body, TraceReport)

    def _ask(self, question: Question) -> Body:
        with self._lock:
            if sum(one.robot == question.robot for one in self._open.values()) >= OPEN_AT_MOST:
                detail = (
                    f"{OPEN_AT_MOST} questions to {question.robot} are open; ask again when it has answered"
                )
                raise Busy(detail, code="too-many-questions")
            self._unsent.append(question)
            self._open[question.id] = question
        try:
            return question.answer.result(self._patience_s)
        except TooLate:
            detail = f"{question.robot} has not answered within {self._patience_s:g} s; ask again when it is online"
            raise Silent(detail) from None
        finally:
            with self._lock:
                self._open.pop(question.id, None)
                if question in self._unsent:
                    self._unsent.remove(question)
