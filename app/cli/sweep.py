"""`macta experiment sweep`: how often goals come true in a simulated world, over many seeds."""

import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress

from app.cli.goal_input import StatedGoals, read_goals
from app.cli.simulated_mission import simulate_mission
from app.cli.start_progress import StartProgress
from app.cli.trials.offline_mission import NoMission, goal_problem, plan_mission
from app.cli.trials.random_goals import drawn_goals
from app.cli.trials.sweep_results import Group, Outcome, SeedResult, Spread, SweepSummary
from app.domain.errors import Invalid
from app.domain.goal_language.berth_choice import assign_berths
from app.domain.world_model import initial_facts
from app.domain.world_model.senses import Perceives
from app.packs.pack_set import Packs
from app.planning.pool.work import PLANNER
from planner import KnowledgeBase, PlanningEngine, PlanningRequest, merge_knowledge_bases
from planner.engines.registry import portfolio
from robots.compilation import compile_once
from robots.repertoire import read_repertoire
from robots.wire import SymbolicFact
from robots.world import WorldFile
from sim.process.first_calls import SIMULATION
from sim.trials.parallel import run_parallel

TIME_LIMIT_S = 30.0
SHOWN_SEEDS = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepRequest:
    """The goals of a sweep: the given `sentences`, or `goals` drawn for each seed."""

    world: WorldFile
    packs: Packs
    sentences: tuple[str, ...]
    goals: int


def sweep(request: SweepRequest, seeds: range, *, jobs: int, as_json: bool) -> None:
    """Simulate a mission for every seed and print the outcomes.

    :raises Invalid: if the goals are not understood, or the world has no room for them; before anything is started.
    """
    _wanted(request, seeds[0], request.packs.knowledge_base())
    rows = run_parallel(partial(row_of, request), seeds, workers=jobs)
    if as_json:
        errors = Console(stderr=True)
        with Progress(console=errors, transient=True) as progress:
            done = list(progress.track(rows, total=len(seeds), description="seeds"))
        json.dump(_document(request, done), sys.stdout, indent=2)
        sys.stdout.write("\n")
        return
    console = Console(highlight=False, soft_wrap=True)
    _show_tally(console, SweepSummary.of(list(_shown(console, rows))))


def row_of(request: SweepRequest, seed: int) -> SeedResult:
    """Plan and simulate one seed."""
    base, engine = _planning(request.packs.knowledge_bases)
    goal = "none"
    try:
        wanted = _wanted(request, seed, base)
        goal = _words(wanted.goals)
        facts = initial_facts(request.world, base)
        problem = goal_problem(
            request.world, facts, wanted.goals, base, wanted.constraints, _perceives(request.packs.packets)
        )
        mission = plan_mission(
            request.world,
            problem,
            engine,
            base,
            PlanningRequest(time_limit_s=TIME_LIMIT_S),
            library=request.packs.library(),
        )
    except (Invalid, NoMission) as refusal:
        return SeedResult(seed=seed, goal=goal, outcome=Outcome.UNPLANNED, reason=str(refusal))
    ended = simulate_mission(mission, seed=seed, packet_files=request.packs.packets)
    return SeedResult(
        seed=seed,
        goal=goal,
        outcome=ended.outcome,
        took_s=ended.truth.time_s,
        estimate_s=mission.plan_net.makespan_s,
        packet=ended.packet,
        reason=ended.reason,
    )


@cache
def _perceives(packet_files: tuple[Path, ...]) -> Perceives:
    return read_repertoire(packet_files).senses


@cache
def _planning(knowledge_bases: tuple[Path, ...]) -> tuple[KnowledgeBase, PlanningEngine]:
    """Made once per process."""
    with StartProgress(Console(stderr=True)) as start:
        for group in (PLANNER, SIMULATION):
            compile_once(group, start.tell)
    base = merge_knowledge_bases(knowledge_bases)
    return base, portfolio(base)


def _wanted(request: SweepRequest, seed: int, base: KnowledgeBase) -> StatedGoals:
    """The seed's goals, each with a free berth."""
    facts = initial_facts(request.world, base)
    if request.sentences:
        return read_goals(request.world, facts, request.sentences, base, request.packs.verbs())
    drawn = drawn_goals(request.world, facts, request.goals, seed, base)
    return StatedGoals(goals=assign_berths(drawn, request.world, facts))


def _words(goals: Sequence[SymbolicFact]) -> str:
    return " and ".join(
        f"move {' to '.join(goal.args)}" if goal.predicate == "in" else str(goal) for goal in goals
    )


def _document(request: SweepRequest, rows: Sequence[SeedResult]) -> dict[str, Any]:
    tally = SweepSummary.of(rows)
    return {
        "world": request.world.name,
        "rows": [asdict(row) | {"ratio": row.ratio} for row in rows],
        "summary": asdict(tally) | {"rate": tally.rate},
    }


def _shown(console: Console, rows: Iterator[SeedResult]) -> Iterator[SeedResult]:
    """Print each row as it arrives, and pass it on."""
    console.print(f"[bold]{'seed':>5}  {'outcome':<10} {'time s':>7} {'/ estimated':>12}  goal[/]")
    for row in rows:
        took = "" if row.took_s is None else f"{row.took_s:.1f}"
        ratio = "" if row.ratio is None else f"{row.ratio:.2f}"
        outcome = f"{row.outcome.replace('_', ' '):<10}"
        if row.outcome is not Outcome.CAME_TRUE:
            outcome = f"[red]{outcome}[/]"
        console.print(f"{row.seed:>5}  {outcome} {took:>7} {ratio:>12}  {escape(row.goal)}")
        if row.reason:
            console.print(f"{'':7}{escape(_by_packet(row.packet, row.reason))}")
        yield row


def _show_tally(console: Console, tally: SweepSummary) -> None:
    console.print()
    if tally.interval is None:
        console.print(f"No mission was run: none of {tally.seeds} seeds had a plan.")
    else:
        low, high = tally.interval
        share = f"{tally.came_true} of {tally.tried} came true"
        console.print(
            f"[bold]{share}[/]: {100 * (tally.rate or 0):.1f} % (95 %: {100 * low:.1f} to {100 * high:.1f})."
        )
    _show_spread(console, "Time, s", tally.took_s, 1)
    _show_spread(console, "Time over estimate", tally.ratio, 2)
    _show_groups(console, "Not come true:", tally.failures)
    _show_groups(console, "Not tried, no plan:", tally.unplanned)


def _show_spread(console: Console, what: str, spread: Spread | None, digits: int) -> None:
    if spread is not None:
        ends = f"{spread.least:.{digits}f} to {spread.most:.{digits}f}"
        console.print(f"{what}: median {spread.median:.{digits}f}, {ends}.")


def _show_groups(console: Console, heading: str, groups: Sequence[Group]) -> None:
    if not groups:
        return
    console.print(heading)
    for group in groups:
        seeds = ", ".join(map(str, group.seeds[:SHOWN_SEEDS])) + (
            ", …" if len(group.seeds) > SHOWN_SEEDS else ""
        )
        outcome = group.outcome.replace("_", " ")
        words = escape(_by_packet(group.packet, group.reason))
        console.print(f"{len(group.seeds):>5} × {outcome}: {words} (seeds {seeds})")


def _by_packet(packet: str | None, reason: str) -> str:
    return reason if packet is None else f"{packet}: {reason}"
