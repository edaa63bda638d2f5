"""`macta plan`: plan only, without a server or a simulation, from the world file's initial facts."""

import json
import sys

from rich.console import Console

from app.cli.main import fail
from app.cli.show import show_plan
from app.goals.check import blocking, check_goals
from app.goals.grammar import Clarification, parse_goal
from app.plan_body import PlanBody
from app.vocabulary import planner_fact
from app.world_model import initial_facts, initial_spots, objects_of, planning_problem
from planner import KnowledgeBase, PlanningProblem, PlanningResult, load_knowledge_base
from planner.fast_downward import FastDownwardEngine
from robots.wire import SymbolicFact
from robots.world import WorldFile


def plan(world: WorldFile, sentences: list[str], time_limit_s: float, *, as_json: bool) -> int:
    """Print the plan-net; 0 if there is one, 1 if not."""
    knowledge_base = load_knowledge_base()
    problem = _problem(world, sentences, knowledge_base)
    result = FastDownwardEngine(knowledge_base).plan(problem, time_limit_s=time_limit_s)
    if result.plan_net is None:
        if as_json:
            sys.stdout.write(json.dumps(_refusal(result), indent=2) + "\n")
        Console(stderr=True, highlight=False).print(
            f"[bold red]No plan[/] ({result.status}): {result.reason}"
        )
        return 1
    body = PlanBody.of_result(result, knowledge_base, world=world.name)
    if as_json:
        sys.stdout.write(body.model_dump_json(indent=2) + "\n")
    else:
        show_plan(Console(highlight=False), body)
    return 0


def _refusal(result: PlanningResult) -> dict[str, object]:
    return {
        "status": result.status.value,
        "reason": result.reason,
        "engine": result.engine,
        "planning_s": result.planning_s,
    }


def _problem(world: WorldFile, sentences: list[str], knowledge_base: KnowledgeBase) -> PlanningProblem:
    """The planning problem of the sentences; ends the command if they make none."""
    facts = initial_facts(world, knowledge_base)
    wanted: list[SymbolicFact] = []
    for sentence in sentences:
        parsed = parse_goal(sentence, world, facts)
        if isinstance(parsed, Clarification):
            fail(_with_choices(parsed.detail, parsed.choices))
        wanted.extend(parsed)
    for issue in blocking(check_goals(wanted, world, facts, knowledge_base)):
        fail(_with_choices(issue.detail, issue.choices))
    objects = objects_of(world)
    goals = tuple(planner_fact(fact, knowledge_base, objects) for fact in wanted)
    return planning_problem(world, facts, goals, spots=initial_spots(world))


def _with_choices(detail: str, choices: tuple[str, ...]) -> str:
    return f"{detail}; choices: {', '.join(choices)}" if choices else detail
