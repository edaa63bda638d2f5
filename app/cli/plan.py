"""`macta plan`: plan only, without a server or a simulation, from the world file's initial facts."""

import json
import sys

from rich.console import Console
from rich.markup import escape

from app.cli.show import show_plan
from app.cli.understanding import understood
from app.errors import Invalid
from app.plan_body import PlanBody
from app.vocabulary import planner_fact
from app.world_model import initial_facts, initial_spots, objects_of, planning_problem
from planner import KnowledgeBase, PlanningProblem, PlanningResult, load_knowledge_base
from planner.fast_downward import FastDownwardEngine
from robots.world import WorldFile


def plan(world: WorldFile, sentences: list[str], time_limit_s: float, *, as_json: bool) -> int:
    """Print the plan-net; 0 if there is one, 1 if not.

    :raises Invalid: if the sentences state no goal that makes sense; as JSON that is printed, too.
    """
    knowledge_base = load_knowledge_base()
    try:
        problem = _problem(world, sentences, knowledge_base)
    except Invalid as refusal:
        if as_json:
            _print(
                {
                    "status": "refused",
                    "code": refusal.code,
                    "detail": refusal.detail,
                    "choices": refusal.choices,
                }
            )
        raise
    result = FastDownwardEngine(knowledge_base).plan(problem, time_limit_s=time_limit_s)
    if result.plan_net is None:
        if as_json:
            _print(_without_plan(result))
        words = f"[bold red]No plan[/] ({result.status}): {escape(result.reason)}"
        Console(stderr=True, highlight=False).print(words)
        return 1
    body = PlanBody.of_result(result, knowledge_base, world=world.name)
    if as_json:
        sys.stdout.write(body.model_dump_json(indent=2) + "\n")
    else:
        show_plan(Console(highlight=False), body)
    return 0


def _print(document: dict[str, object]) -> None:
    sys.stdout.write(json.dumps(document, indent=2) + "\n")


def _without_plan(result: PlanningResult) -> dict[str, object]:
    return {
        "status": result.status.value,
        "reason": result.reason,
        "engine": result.engine,
        "planning_s": result.planning_s,
    }


def _problem(world: WorldFile, sentences: list[str], knowledge_base: KnowledgeBase) -> PlanningProblem:
    facts = initial_facts(world, knowledge_base)
    objects = objects_of(world)
    wanted = understood(world, facts, sentences, knowledge_base)
    goals = tuple(planner_fact(fact, knowledge_base, objects) for fact in wanted)
    return planning_problem(world, facts, goals, spots=initial_spots(world))
