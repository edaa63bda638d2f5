from dataclasses import replace

from planner import UNOBSERVED, KnowledgeBase, Observer, PlanningProblem, PlanningRequest, PlanningResult
from planner.engines.registry import engine_named


class Draft:
    name = "draft"

    def __init__(self, base: KnowledgeBase) -> None:
        self.engine = engine_named("macta", base)

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        found = self.engine.plan(problem, replace(request, effort_s=0), observer)
        return replace(found, engine=self.name)
