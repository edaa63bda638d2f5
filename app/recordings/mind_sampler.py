"""Asks recorded robots for their minds, so that recordings have what they believed and which rules fired."""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

from app.agents.questions import Question, Questions
from app.domain.clock import SYSTEM_CLOCK, WallClock
from robots.wire import MindReport

EVERY_S = 1.0
"""Wall-clock seconds between two questions to a robot. A report has the firings since, so that none is missed sooner
than the robot keeps the last 64."""
PATIENCE_S = 5.0
"""Wall-clock seconds after which an answer is not awaited any longer."""


@dataclass(slots=True)
class _Asked:
    """A robot that is asked. `question`: open; None between two. `has_mind`: False once it has told of no rules."""

    due_s: float = 0.0
    question: Question | None = None
    has_mind: bool = True


class MindSampler:
    """Called in each turn of the recorder; never waits."""

    def __init__(
        self, questions: Questions, *, is_cheap: Callable[[str], bool], wall: WallClock = SYSTEM_CLOCK
    ) -> None:
        """:param is_cheap: true of robots whose radio has room for the questions."""
        self._questions = questions
        self._is_cheap = is_cheap
        self._wall = wall
        self._asked: dict[str, _Asked] = {}

    def reports(self, robots: Collection[str]) -> Iterator[tuple[str, MindReport]]:
        """The answers that have come; asks the robots that are due. Others than these are not asked any longer."""
        now_s = self._wall.monotonic_s()
        for name in self._asked.keys() - set(robots):
            self._drop(self._asked.pop(name))
        for name in robots:
            one = self._asked.setdefault(name, _Asked())
            if one.question is not None and one.question.answer.done():
                answer = one.question.answer.result()
                one.question = None
                one.has_mind = isinstance(answer, MindReport) and bool(answer.agents)
                if isinstance(answer, MindReport) and answer.agents:
                    yield name, answer
            elif one.question is not None and now_s >= one.due_s - EVERY_S + PATIENCE_S:
                self._drop(one)
            if one.question is None and one.has_mind and now_s >= one.due_s and self._is_cheap(name):
                one.due_s = now_s + EVERY_S
                one.question = self._questions.begin_mind(name)

    def rules_changed(self, robot: str) -> None:
        """Ask a robot again that had no rules."""
        if robot in self._asked:
            self._asked[robot].has_mind = True

    def _drop(self, one: _Asked) -> None:
        if one.question is not None:
            self._questions.withdraw(one.question)
            one.question = None
