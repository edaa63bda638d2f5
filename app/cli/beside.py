"""What `macta plan` shows beside the plan where it is asked for: alternatives and the explanation."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from app.domain.explanation_document import ActionExplanationBody, ExplanationBody
from app.domain.plan_document import PlanBody
from planner import KnowledgeBase, Observer, PlanningEngine, PlanningProblem, PlanningRequest, PlanningResult
from planner.alternatives import alternatives
from planner.explanation import explain

MOST_WAITS = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Beside:
    """What stands beside a plan; None where it was not asked for."""

    alternatives: tuple[PlanBody, ...] | None = None
    explanation: ExplanationBody | None = None

    def document(self, plan: PlanBody) -> dict[str, Any]:
        """For JSON: the plan body itself, or in `plan` where something stands beside it."""
        if self.alternatives is None and self.explanation is None:
            return plan.model_dump(mode="json")
        document: dict[str, Any] = {"plan": plan.model_dump(mode="json")}
        if self.alternatives is not None:
            document["alternatives"] = [one.model_dump(mode="json") for one in self.alternatives]
        if self.explanation is not None:
            document["explanation"] = self.explanation.model_dump(mode="json")
        return document

    def show(self, console: Console, plan: PlanBody) -> None:
        if self.alternatives is not None:
            console.print(_comparison(self.alternatives))
        if self.explanation is not None:
            _show_explanation(console, plan, self.explanation)


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """What an operator wants beside the plan.

    :param alternatives: at most so many; 0 for none.
    """

    alternatives: int = 0
    explanation: bool = False

    def find(
        self,
        engine: PlanningEngine,
        knowledge_base: KnowledgeBase,
        problem: PlanningProblem,
        request: PlanningRequest,
        observer: Observer,
        result: PlanningResult,
    ) -> Beside:
        """What is wanted beside a solution of the problem; nothing if the result is none."""
        if result.plan_net is None:
            return Beside()
        others = explained = None
        if self.alternatives:
            found = alternatives(
                engine,
                knowledge_base,
                problem,
                request,
                observer,
                k=self.alternatives,
                proposed=result,
            )
            others = tuple(
                PlanBody.of_result(one.result, knowledge_base, label=one.label, comparison=one.words)
                for one in found
            )
        if self.explanation:
            why = explain(result.plan_net, problem, knowledge_base, engine, request, observer)
            explained = ExplanationBody.of(why, knowledge_base)
        return Beside(alternatives=others, explanation=explained)


def _comparison(plans: Sequence[PlanBody]) -> Table:
    table = Table(title="To choose from", title_justify="left", box=SIMPLE_HEAD)
    table.add_column("Best at")
    for name in ("Takes, s", "Drives, m", "Uses, J", "To clear"):
        table.add_column(name, justify="right")
    table.add_column("Robots", style="cyan")
    for plan in plans:
        table.add_row(
            escape(plan.label),
            f"{plan.makespan_s:.1f}",
            f"{plan.distance_m:.1f}",
            f"{plan.energy_j:.0f}",
            str(plan.clearances),
            ", ".join(plan.robots),
        )
    return table


def _show_explanation(console: Console, plan: PlanBody, explanation: ExplanationBody) -> None:
    console.print("[bold]Why[/]")
    for action, why in zip(plan.actions, explanation.actions, strict=True):
        console.print(f"[bold]{action.id}[/] {escape(action.description)}")
        for words in _reasons(why):
            console.print(f"    {escape(words)}")
    console.print("\n[bold]What makes the time[/]")
    for words in explanation.makespan:
        console.print(f"  {escape(words)}")
    for wait in explanation.waits[:MOST_WAITS]:
        console.print(f"  {escape(wait.words)}")
    for robot, words in explanation.robots.items():
        console.print(f"[bold]{robot}[/]: {escape(words)}")
    console.print()


def _reasons(why: ActionExplanationBody) -> list[str]:
    """What the action itself brings about and for which goals, why its robots, and what it comes after."""
    in_the_end = f"; in the end for {', '.join(map(str, why.goals))}" if len(why.chain) > 1 else ""
    purpose = [why.because[0] + in_the_end] if why.because else []
    robots = [f"{robot}: {words}" for robot, words in why.robots.items()]
    return [*purpose, *robots, *(words for words in why.order if words.startswith("after "))]
