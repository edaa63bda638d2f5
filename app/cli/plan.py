"""`macta plan`: plan only, without a server or a simulation, from the world file's initial facts."""

import json
import sys
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape

from app.cli.goal_input import read_goals
from app.cli.progress_line import ProgressLine
from app.cli.render import show_alternatives, show_explanation, show_plan, show_terms
from app.cli.start_progress import StartProgress
from app.cli.trials.offline_mission import goal_problem
from app.domain.errors import Invalid
from app.domain.explanation_document import ExplanationBody
from app.domain.goal_language.constraints import Constraints
from app.domain.goal_language.verbs import Verbs
from app.domain.plan_document import ForecastBody, PlanBody
from app.domain.world_model import initial_facts
from app.domain.world_model.senses import Perceives
from app.planning.pool.waiting_line import is_large
from app.planning.pool.work import PLANNER
from planner import (
    KnowledgeBase,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    warm_up,
)
from planner.alternatives import alternatives, with_choices_of
from planner.errors import UnknownEngine, Unsupported
from planner.explanation import UNCONSTRAINED, explain
from planner.interchange.foreign import ReadProblem, import_problem
from planner.interchange.pddl import Form, pddl_of
from planner.plan_nets.completion import forecast
from planner.problem.choices import as_chosen_by, without_each_preference
from robots.compilation import compile_once, is_compiled, uncompiled
from robots.world import WorldFile


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanExtras:
    """Extras shown with a plan; None where not requested."""

    alternatives: tuple[PlanBody, ...] | None = None
    explanation: ExplanationBody | None = None

    def document(self, plan: PlanBody) -> dict[str, Any]:
        """The JSON document: the plan body, or an object with `plan` and the extras."""
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
            show_alternatives(console, self.alternatives)
        if self.explanation is not None:
            show_explanation(console, plan, self.explanation)


@dataclass(frozen=True, slots=True, kw_only=True)
class ExtrasRequest:
    """The extras to show with a plan.

    :param alternatives: the most alternatives to find; 0 for none.
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
        without: Mapping[str, PlanningProblem] = UNCONSTRAINED,
    ) -> PlanExtras:
        """Find the extras of a solution; none if the result has no plan.

        :param without: by constraint, in words, the problem without that one.
        """
        if result.plan_net is None:
            return PlanExtras()
        others = None
        explained = None
        of_plan = as_chosen_by(result.plan_net, problem)
        if self.alternatives:
            found = alternatives(
                engine,
                knowledge_base,
                of_plan,
                request,
                observer,
                k=self.alternatives,
                proposed=result,
            )
            others = tuple(
                PlanBody.of_result(
                    with_choices_of(result, one.result, problem.preferences),
                    knowledge_base,
                    label=one.label,
                    comparison=one.words,
                    forecast=ForecastBody.of(one.forecast, knowledge_base),
                )
                for one in found
            )
        if self.explanation:
            without = {words: as_chosen_by(result.plan_net, one) for words, one in without.items()}
            without |= dict(without_each_preference(result.plan_net, problem))
            why = explain(
                result.plan_net, of_plan, knowledge_base, engine, request, observer, without=without
            )
            explained = ExplanationBody.of(why, knowledge_base)
        return PlanExtras(alternatives=others, explanation=explained)


NO_EXTRAS = ExtrasRequest()


def plan(
    world: WorldFile,
    knowledge_base: KnowledgeBase,
    sentences: list[str],
    request: PlanningRequest,
    *,
    engine_name: str,
    as_json: bool,
    extras: ExtrasRequest = NO_EXTRAS,
    deadline_s: float | None = None,
    not_before_s: float | None = None,
    pddl: Path | None = None,
    verbs: Verbs | None = None,
    perceives: Perceives | None = None,
    optional: Sequence[str] = (),
) -> int:
    """Print the plan-net; 0 if there is one or nothing is to be done, 1 if not. Ctrl-C takes the best one so far.

    :param extras: what to show with the plan.
    :param deadline_s: when every goal must be true, from the plan's start.
    :param not_before_s: until when none is to become true, likewise.
    :param pddl: a folder to write the problem to as PDDL before it is planned.
    :param verbs: of the sentences; default: those that ship with Macta.
    :param perceives: what robots sense by their sensors that do not say what they sense; None: all.
    :param optional: goals that may be left out, each as `VALUE: GOAL`.
    :raises Invalid: if a goal is malformed or impossible (with `as_json` also printed), or the engine does not
        exist.
    """
    facts = initial_facts(world, knowledge_base)
    try:
        stated = read_goals(world, facts, sentences, knowledge_base, verbs, optional)
        if stated.due is not None and deadline_s is not None:
            raise Invalid("a goal states a deadline, and so does --deadline; say one", code="two-deadlines")
    except Invalid as refusal:
        if as_json:
            _print(
                {
                    "status": "refused",
                    "code": refusal.code,
                    "detail": refusal.detail,
                    "choices": refusal.choices,
                    "constraints": refusal.constraints,
                    "thing": refusal.thing,
                    "span": refusal.span,
                }
            )
        raise
    if stated.nothing_to_do:
        if as_json:
            _print({"status": "nothing_to_do", "holds": [hold.words for hold in stated.holds]})
        else:
            show_terms(Console(stderr=True, highlight=False), stated.readings)
            Console(highlight=False).print(escape(_sentence(stated.nothing_to_do)))
        return 0
    if stated.due is not None:
        deadline_s = stated.due.in_s

    def constrained(constraints: Constraints) -> PlanningProblem:
        problem = goal_problem(world, facts, stated.goals, knowledge_base, constraints, perceives)
        if deadline_s is not None:
            problem = replace(problem, deadlines_s=dict.fromkeys(problem.goals, deadline_s))
        if not_before_s is not None:
            problem = replace(problem, not_before_s=dict.fromkeys(problem.goals, not_before_s))
        return problem

    problem = constrained(stated.constraints)
    if not as_json:
        show_terms(
            Console(stderr=True, highlight=False),
            stated.readings,
            stated.constraints,
            stated.holds,
        )
    if pddl is not None:
        _write_pddl(pddl, knowledge_base, problem)
    others = stated.constraints.without_each() if extras.explanation else {}
    return _plan(
        engine_name,
        problem,
        request,
        knowledge_base,
        as_json=as_json,
        extras=extras,
        world=world.name,
        without={words: constrained(rest) for words, rest in others.items()},
    )


def plan_pddl(
    domain: Path,
    problem: Path,
    agents: list[str],
    request: PlanningRequest,
    *,
    engine_name: str,
    as_json: bool,
    extras: ExtrasRequest = NO_EXTRAS,
) -> int:
    """As `plan`, for a problem that PDDL files state.

    :raises Invalid: if a file is missing, no PDDL, or has features we cannot plan with.
    """
    read = _read_pddl(domain, problem, agents)
    return _plan(
        engine_name,
        read.problem,
        request,
        read.knowledge_base,
        as_json=as_json,
        extras=extras,
        world=problem.stem,
        is_foreign=True,
    )


def _plan(
    engine_name: str,
    problem: PlanningProblem,
    request: PlanningRequest,
    knowledge_base: KnowledgeBase,
    *,
    as_json: bool,
    extras: ExtrasRequest,
    world: str,
    without: Mapping[str, PlanningProblem] = UNCONSTRAINED,
    is_foreign: bool = False,
) -> int:
    errors = Console(stderr=True, highlight=False)
    is_compiled_now = is_compiled(PLANNER) or is_large(goals=len(problem.goals), effort_s=request.effort_s)
    if is_compiled_now:
        with StartProgress(errors) as start:
            compile_once(PLANNER, start.tell)
    with (
        nullcontext() if is_compiled_now else uncompiled(),
        ProgressLine(errors, is_shown=errors.is_terminal and not as_json) as progress,
    ):
        engine = _engine(engine_name, knowledge_base, is_foreign=is_foreign)
        warm_up(engine)
        result = engine.plan(problem, request, progress)
        found = extras.find(engine, knowledge_base, problem, request, progress, result, without)
    if result.plan_net is None:
        if as_json:
            _print(_without_plan(result))
        words = f"[bold red]No plan[/] ({result.status}): {escape(result.reason)}"
        errors.print(words)
        return 1
    body = PlanBody.of_result(
        result,
        knowledge_base,
        world=world,
        forecast=ForecastBody.of(
            forecast(result.plan_net, problem.deadlines_s, problem.spreads), knowledge_base
        ),
    )
    if as_json:
        _print(found.document(body))
    else:
        console = Console(highlight=False)
        show_plan(console, body)
        found.show(console, body)
    return 0


def _write_pddl(folder: Path, knowledge_base: KnowledgeBase, problem: PlanningProblem) -> None:
    """Write `domain.pddl` and `problem.pddl`, temporal; both with the numbers that plans keep in the folder `numeric`,
    and with action costs in `classical`.

    :raises Invalid: if they cannot be written.
    """
    folders = {Form.TEMPORAL: folder, Form.NUMERIC: folder / "numeric", Form.CLASSICAL: folder / "classical"}
    for form, place in folders.items():
        domain_text, problem_text = pddl_of(knowledge_base, problem, form)
        try:
            place.mkdir(parents=True, exist_ok=True)
            (place / "domain.pddl").write_text(domain_text)
            (place / "problem.pddl").write_text(problem_text)
        except OSError as error:
            raise Invalid(f"--pddl: {place} cannot be written: {error.strerror}") from error


def _read_pddl(domain: Path, problem: Path, agents: list[str]) -> ReadProblem:
    """:raises Invalid: if a file cannot be read, is not PDDL, or has features we cannot plan with."""
    try:
        return import_problem(domain.read_text(), problem.read_text(), agents=agents)
    except OSError as error:
        raise Invalid(f"{error.filename} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise Invalid(f"{domain} or {problem} is not text: {error.reason}") from error
    except Unsupported as error:
        raise Invalid(f"{domain}, {problem}: {error}") from error


def _engine(name: str, knowledge_base: KnowledgeBase, *, is_foreign: bool) -> PlanningEngine:
    # NOTE: imported here: the import decides whether the planner is compiled.
    from planner.engines.portfolio import Portfolio
    from planner.engines.registry import engine_named, improving_portfolio

    if is_foreign and name == Portfolio.name:
        return improving_portfolio(knowledge_base)
    try:
        return engine_named(name, knowledge_base)
    except UnknownEngine as error:
        raise Invalid(f"--engine: {error}") from error


def _print(document: dict[str, object]) -> None:
    sys.stdout.write(json.dumps(document, indent=2) + "\n")


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."


def _without_plan(result: PlanningResult) -> dict[str, object]:
    return {
        "status": result.status.value,
        "reason": result.reason,
        "engine": result.engine,
        "planning_s": result.planning_s,
    }
