"""`macta plan`: plan only, without a server or a simulation, from the world file's initial facts."""

import json
import sys
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from app.cli.beside import Wanted
from app.cli.live import LivePlanning
from app.cli.pddl import read_files, write_files
from app.cli.show import show_plan
from app.cli.understanding import understood
from app.domain.errors import Invalid
from app.domain.plan_document import PlanBody
from app.domain.world_model import initial_facts
from app.trials.offline_mission import goal_problem
from planner import (
    KnowledgeBase,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    warm_up,
)
from planner.engines.registry import engine_named
from planner.errors import UnknownEngine
from robots.world import WorldFile

NOTHING_MORE = Wanted()


def plan(
    world: WorldFile,
    knowledge_base: KnowledgeBase,
    sentences: list[str],
    request: PlanningRequest,
    *,
    engine_name: str,
    as_json: bool,
    wanted: Wanted = NOTHING_MORE,
    deadline_s: float | None = None,
    pddl: Path | None = None,
) -> int:
    """Print the plan-net; 0 if there is one, 1 if not. Ctrl-C takes the best one so far.

    :param wanted: what to show beside the plan.
    :param deadline_s: by when every goal is to be true, from the plan's start.
    :param pddl: a folder to write the problem to as PDDL before it is planned.
    :raises Invalid: if the sentences state no goal that makes sense (as JSON that is printed, too), or the
        engine does not exist.
    """
    engine = _engine(engine_name, knowledge_base)
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
    if deadline_s is not None:
        problem = replace(problem, deadlines_s=dict.fromkeys(problem.goals, deadline_s))
    if pddl is not None:
        write_files(pddl, knowledge_base, problem)
    return _answer(engine, problem, request, knowledge_base, as_json=as_json, wanted=wanted, world=world.name)


def plan_pddl(
    domain: Path,
    problem: Path,
    agents: list[str],
    request: PlanningRequest,
    *,
    engine_name: str,
    as_json: bool,
    wanted: Wanted = NOTHING_MORE,
) -> int:
    """As `plan`, for a problem that PDDL files state.

    :raises Invalid: if a file is missing, no PDDL, or has features we cannot plan with.
    """
    read = read_files(domain, problem, agents)
    engine = _engine(engine_name, read.knowledge_base)
    return _answer(
        engine,
        read.problem,
        request,
        read.knowledge_base,
        as_json=as_json,
        wanted=wanted,
        world=problem.stem,
    )


def _answer(
    engine: PlanningEngine,
    problem: PlanningProblem,
    request: PlanningRequest,
    knowledge_base: KnowledgeBase,
    *,
    as_json: bool,
    wanted: Wanted,
    world: str,
) -> int:
    errors = Console(stderr=True, highlight=False)
    with LivePlanning(errors, is_shown=errors.is_terminal and not as_json) as live:
        warm_up(engine)
        result = engine.plan(problem, request, live)
        beside = wanted.find(engine, knowledge_base, problem, request, live, result)
    if result.plan_net is None:
        if as_json:
            _print(_without_plan(result))
        words = f"[bold red]No plan[/] ({result.status}): {escape(result.reason)}"
        errors.print(words)
        return 1
    body = PlanBody.of_result(result, knowledge_base, world=world)
    if as_json:
        _print(beside.document(body))
    else:
        console = Console(highlight=False)
        show_plan(console, body)
        beside.show(console, body)
    return 0


def _engine(name: str, knowledge_base: KnowledgeBase) -> PlanningEngine:
    try:
        return engine_named(name, knowledge_base)
    except UnknownEngine as error:
        raise Invalid(f"--engine: {error}") from error


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
    return goal_problem(world, facts, understood(world, facts, sentences, knowledge_base), knowledge_base)
