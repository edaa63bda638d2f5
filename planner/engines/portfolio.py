"""Several engines as one: each is asked only if those before it found nothing."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace

from planner.engines.optional import not_installed
from planner.problem.interface import (
    UNOBSERVED,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    Progress,
    warm_up,
)
from planner.problem.timer import Timer

MIN_SHARE_S = 0.05
"""With less time left, no further engine is asked."""

_STATUS_TEXT = {
    PlanningStatus.UNSOLVABLE: "proves that there is no plan",
    PlanningStatus.TIMED_OUT: "found no plan in its time",
    PlanningStatus.OUT_OF_MEMORY: "ran out of memory",
    PlanningStatus.NOT_FOUND: "found no plan",
    PlanningStatus.FAILED: "failed",
}
"""The most informative first."""

logger = logging.getLogger(__name__)


class Portfolio:
    """Asks its engines in turn until one finds a plan or proves that there is none.

    Each gets half of the time that is left, the last one all of it; unused time goes to the others. The
    answer names the engine that gave it and carries the best bound that any of them proved.

    :param missing: the names of engines that are not installed; an answer without plan or proof says so.
    """

    name = "portfolio"

    def __init__(self, engines: Sequence[PlanningEngine], *, missing: Sequence[str] = ()) -> None:
        """:raises ValueError: if there are none."""
        if not engines:
            raise ValueError("a portfolio needs at least one engine")
        self.engines = tuple(engines)
        self.missing = tuple(missing)

    def warm_up(self) -> None:
        """Warm up every engine; a failure of one does not affect the others."""
        for engine in self.engines:
            try:
                warm_up(engine)
            except Exception:
                logger.exception("engine %s could not be prepared in advance", engine.name)

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        return self._first(problem, request, Relay(observer, request.timer())).answer

    def _first(self, problem: PlanningProblem, request: PlanningRequest, relay: "Relay") -> "First":
        """The first plan or proof; else why there is none."""
        answers: list[PlanningResult] = []
        for index, engine in enumerate(self.engines):
            begun_s = relay.timer.elapsed_s
            left_s = relay.timer.left_s
            if answers and (left_s < MIN_SHARE_S or relay.should_stop()):
                break
            share_s = left_s if engine is self.engines[-1] else left_s / 2
            answer = ask(engine, problem, replace(request, time_limit_s=share_s), relay)
            relay.learn(answer.lower_bound_s)
            if answer.plan_net is not None:
                before = _summary(answers) if index else answer.reason
                took_s = relay.timer.elapsed_s - begun_s
                return First(answer=self.concluded(answer, before, relay), index=index, took_s=took_s)
            answers.append(answer)
            if answer.status is PlanningStatus.UNSOLVABLE:
                return First(answer=self.concluded(answer, answer.reason, relay))
        return First(answer=self._none_found(answers, relay.should_stop(), relay))

    def _none_found(self, answers: Sequence[PlanningResult], stopped: bool, relay: "Relay") -> PlanningResult:
        status = min((answer.status for answer in answers), key=list(_STATUS_TEXT).index)
        reason = _summary(answers)
        if stopped:
            status = PlanningStatus.NOT_FOUND
            reason = f"stopped before a plan was found; {reason}"
        elif status is not PlanningStatus.FAILED:
            reason += "; that does not prove that there is none"
            if self.missing:
                reason += f". Engines that may find one or prove it are {not_installed(self.missing)}"
        return self.concluded(PlanningResult(status=status, engine=self.name, planning_s=0.0), reason, relay)

    @staticmethod
    def concluded(answer: PlanningResult, reason: str, relay: "Relay") -> PlanningResult:
        """The answer as the portfolio's: its whole time, its best bound."""
        return replace(
            answer,
            reason=reason,
            planning_s=round(relay.timer.elapsed_s, 3),
            lower_bound_s=relay.lower_bound_s,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class First:
    """The first plan or proof, or why there is none; the place of its engine, and how long that took."""

    answer: PlanningResult
    index: int = 0
    took_s: float = 0.0


class Relay(Observer):
    """Passes the engines' progress on, in the portfolio's time and with the best bound any of them proved."""

    def __init__(self, observer: Observer, timer: Timer) -> None:
        self._observer = observer
        self.timer = timer
        self.lower_bound_s: float | None = None

    def learn(self, bound_s: float | None) -> None:
        if bound_s is not None:
            self.lower_bound_s = max(bound_s, self.lower_bound_s or 0.0)

    def progress(self, progress: Progress) -> None:
        self.learn(progress.lower_bound_s)
        self._observer.progress(
            replace(progress, elapsed_s=round(self.timer.elapsed_s, 3), lower_bound_s=self.lower_bound_s)
        )

    def should_stop(self) -> bool:
        return self._observer.should_stop()


def ask(
    engine: PlanningEngine, problem: PlanningProblem, request: PlanningRequest, observer: "Relay"
) -> PlanningResult:
    """The engine's answer; an exception is a `FAILED` answer, so that the others are still asked."""
    observer.progress(Progress(engine=engine.name, elapsed_s=0.0))
    try:
        return engine.plan(problem, request, observer)
    except Exception as error:
        logger.exception("engine %s failed", engine.name)
        return PlanningResult(
            status=PlanningStatus.FAILED, engine=engine.name, planning_s=0.0, reason=f"defect: {error}"
        )


def _summary(answers: Sequence[PlanningResult]) -> str:
    """Each engine's status and reason; equal reasons are given once."""
    sentences = []
    said = set[str]()
    for answer in answers:
        why = f" ({answer.reason})" if answer.reason and answer.reason not in said else ""
        said.add(answer.reason)
        sentences.append(f"{answer.engine} {_STATUS_TEXT.get(answer.status, answer.status.value)}{why}")
    return "; ".join(sentences)
