"""What engines share that add something to another engine's answers."""

from dataclasses import replace

from planner.knowledge import KnowledgeBase
from planner.problem.interface import Observer, PlanningEngine, Progress, warm_up


class WrappingEngine:
    """An engine that adds to what another one does, under its name; subclasses plan."""

    def __init__(self, engine: PlanningEngine, knowledge_base: KnowledgeBase) -> None:
        self._engine = engine
        self._base = knowledge_base
        self.name = engine.name

    def warm_up(self) -> None:
        warm_up(self._engine)


class FirstProgress(Observer):
    """Passes on the progress with the problem itself: makespans and bounds of varied ones are none of it."""

    def __init__(self, observer: Observer) -> None:
        self._observer = observer
        self.is_first = True
        """Set to False before varied problems are planned."""

    def progress(self, progress: Progress) -> None:
        if self.is_first:
            self._observer.progress(progress)

    def should_stop(self) -> bool:
        return self._observer.should_stop()


class TimeProgress(Observer):
    """Passes on that time goes by; makespans and bounds of varied problems are none of the whole."""

    def __init__(self, observer: Observer) -> None:
        self._observer = observer

    def progress(self, progress: Progress) -> None:
        self._observer.progress(replace(progress, makespan_s=None, lower_bound_s=None))

    def should_stop(self) -> bool:
        return self._observer.should_stop()
