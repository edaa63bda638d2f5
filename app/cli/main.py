"""The commands and their options; each command imports the module that does its work when it is called."""

import os
from pathlib import Path
from typing import Annotated, Literal

import typer

from app.cli import packs as pack_commands
from app.cli import production, robots, rules, worlds
from app.cli.options import (
    Broker,
    PackNames,
    Speed,
    World,
    Worlds,
    fail,
    leave,
    named_world,
    named_worlds,
    packs_of,
    reported_errors,
)

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Plans goals for teams of robots, has plans approved, and monitors their execution.",
)
WITHOUT_COMPILED_CODE = {"world", "alive", "robot"}
"""Commands that call no compiled function."""


@app.callback()
def choose_cache(context: typer.Context) -> None:
    """Have compiled functions cached, before any module with some is imported."""
    if context.invoked_subcommand not in WITHOUT_COMPILED_CODE:
        from robots.kernels import install

        install()


app.add_typer(worlds.commands, name="world")
app.add_typer(pack_commands.commands, name="pack")
app.add_typer(robots.commands, name="robot")
app.add_typer(rules.commands, name="rules")
experiments = typer.Typer(no_args_is_help=True, help="Run experiments on simulated robots, over many seeds.")
app.add_typer(experiments, name="experiment")
app.command()(production.fleet)
app.command()(production.worker)
app.add_typer(production.alive, name="alive")


@app.command()
def serve(
    world: Worlds = None,
    pack: PackNames = None,
    speed: Annotated[
        float | None,
        typer.Option(min=0.01, help="World seconds per wall-clock second, without --broker (default: 1)."),
    ] = None,
    host: Annotated[str | None, typer.Option(help="Address to listen on (default: loopback).")] = None,
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="Port; 0: any free one (default: 8000).")
    ] = None,
    data: Annotated[Path | None, typer.Option(help="Data folder (default: ./macta-data).")] = None,
    seed: Annotated[
        int | None,
        typer.Option(min=0, help="Seed of the simulation's noise, without --broker (default: 0)."),
    ] = None,
    broker: Broker = None,
    afresh: Annotated[
        bool, typer.Option("--afresh", help="Start the world again, not from its snapshot.")
    ] = False,
) -> None:
    """Serve the HTTP API and the console; worlds are simulated here or, with --broker, by `macta fleet`."""
    from app.cli.shared_modules import shared_by_service
    from robots.child_processes import sharing

    # Before the other imports: it takes a second or two in a process of its own.
    with sharing(*shared_by_service(broker)):
        from app.cli.serve import serve as run

        given = {"host": host, "port": port, "data": data, "broker_url": broker, "packs": pack}
        with reported_errors():
            run(
                named_worlds(world, packs_of(pack)),
                speed,
                seed,
                {k: v for k, v in given.items() if v is not None},
                start_new=afresh,
            )
        leave(0)


@app.command()
def demo(
    world: World = None,
    goal: Annotated[
        str | None, typer.Option(help="Goal, as a sentence or fact.", show_default="the pack's example")
    ] = None,
    pack: PackNames = None,
    speed: Annotated[float | None, typer.Option(min=0.01, help="World seconds per wall-clock second.")] = 4.0,
    flat_out: Annotated[bool, typer.Option(help="Run as fast as possible; overrides --speed.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of start poses and noise.")] = 0,
    allocation: Annotated[
        Literal["central", "contract_net"],
        typer.Option(help="Choose robots by planning alone, or by their bids for the legs of a first plan."),
    ] = "central",
) -> None:
    """Plan a goal, approve the plan and watch simulated robots carry it out, in the terminal."""
    from planner.engines.garbage_collection import loading

    with loading():
        from app.cli.demo import demo as run

    with reported_errors():
        packs = packs_of(pack)
        wanted = goal or packs.example
        if not wanted:
            fail("give --goal")
        pace = None if flat_out else speed
        leave(run(named_world(world, packs), packs, wanted, pace, seed, allocation=allocation))


@app.command()
def plan(
    goal: Annotated[list[str] | None, typer.Option(help="Goal, as a sentence or fact; repeatable.")] = None,
    optional: Annotated[
        list[str] | None,
        typer.Option(
            help="Goal that may be left out, with what it is worth: '5: move sample_1 to bay_7'; repeatable."
        ),
    ] = None,
    world: World = None,
    pack: PackNames = None,
    time_limit: Annotated[float, typer.Option(min=0.1, help="Planning time limit, in seconds.")] = 30.0,
    effort: Annotated[
        float | None, typer.Option(min=0, help="Seconds to improve the first plan (default: by its size).")
    ] = None,
    objective: Annotated[
        Literal["makespan", "robots", "energy", "on_time"],
        typer.Option(help="Quantity to minimise; on_time: the goals that are expected to miss the deadline."),
    ] = "makespan",
    deadline: Annotated[float | None, typer.Option(help="Seconds until every goal must be true.")] = None,
    not_before: Annotated[
        float | None, typer.Option(help="Seconds until which no goal is to become true.")
    ] = None,
    engine: Annotated[
        str,
        typer.Option(
            help="Planning engine; `portfolio` tries all that are installed. An unknown name lists them."
        ),
    ] = "portfolio",
    json: Annotated[bool, typer.Option("--json", help="Print only the plan, as JSON.")] = False,
    alternatives: Annotated[
        int, typer.Option(min=0, max=20, help="Count of different plans to compare.")
    ] = 0,
    explain: Annotated[bool, typer.Option("--explain", help="Explain the plan.")] = False,
    knowledge_base: Annotated[
        Path | None, typer.Option(help="Knowledge base file to use instead of those of the packs.")
    ] = None,
    pddl: Annotated[Path | None, typer.Option(help="Folder to write the problem to as PDDL.")] = None,
    domain: Annotated[Path | None, typer.Option(help="PDDL domain to plan in, instead of a world.")] = None,
    problem: Annotated[Path | None, typer.Option(help="PDDL problem of that domain.")] = None,
    agent: Annotated[
        list[str] | None,
        typer.Option(
            help="Type of the PDDL domain's agents; repeatable (default: actions' first parameters)."
        ),
    ] = None,
) -> None:
    """Plan without a service and print the plan-net. Ctrl-C stops with the best plan so far."""
    from app.cli.plan import ExtrasRequest, plan_pddl
    from app.cli.plan import plan as run
    from planner import Objective, PlanningRequest, load_knowledge_base
    from robots.repertoire import read_repertoire

    extras = ExtrasRequest(alternatives=alternatives, explanation=explain)
    with reported_errors():
        request = PlanningRequest(time_limit_s=time_limit, effort_s=effort, objective=Objective(objective))
        if domain and problem and not (goal or optional or pddl or knowledge_base or deadline or not_before):
            given = (domain, problem, agent or [], request)
            raise typer.Exit(plan_pddl(*given, engine_name=engine, as_json=json, extras=extras))
        if domain or problem or agent or not (goal or optional):
            fail("give --goal, or --domain and --problem with --agent if need be")
        packs = packs_of(pack)
        base = packs.knowledge_base() if knowledge_base is None else load_knowledge_base(knowledge_base)
        raise typer.Exit(
            run(
                named_world(world, packs, base),
                base,
                goal or [],
                request,
                engine_name=engine,
                as_json=json,
                extras=extras,
                deadline_s=deadline,
                not_before_s=not_before,
                pddl=pddl,
                verbs=packs.verbs(),
                perceives=read_repertoire(packs.packets).senses,
                optional=optional or (),
            )
        )


@app.command()
def soak(
    minutes: Annotated[
        float, typer.Option(min=0.1, help="Duration in minutes, without the last check.")
    ] = 10.0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of goals and faults.")] = 0,
    world: World = None,
    pack: PackNames = None,
    speed: Speed = 6.0,
    database_url: Annotated[
        str | None,
        typer.Option(help="Database of the tested service (default: SQLite in a temporary folder)."),
    ] = None,
) -> None:
    """Test a service with random goals, kills and outages, and compare its answers with the simulation's ground truth.

    Goals move samples; with --pack they are sentences of all verbs of the packs.
    Exits with 0 only if every check passed. The tested service does not get this command's `MACTA_…` variables.
    """
    from app.cli.soak import SoakRequest
    from app.cli.soak import soak as run

    with reported_errors():
        packs = packs_of(pack) if pack else None
        request = SoakRequest(
            world=named_world(world, packs),
            packs=packs,
            minutes=minutes,
            seed=seed,
            speed=speed or 6.0,
            database_url=database_url,
        )
        raise typer.Exit(run(request))


@experiments.command()
def interference(
    seeds: Annotated[int, typer.Option(min=1, help="Trials per cell of the table.")] = 10,
    json: Annotated[bool, typer.Option("--json", help="Print only the rows, as JSON.")] = False,
    plots: Annotated[Path, typer.Option(help="Folder for the figures, as SVG.")] = Path("macta-figures"),
) -> None:
    """Compare parallel with sequential sensing of obstacles on a robot's way to a door (P-SMPA, section 6).

    Prints table 1 (detected obstacles and time) and writes figures like 5 and 6.
    """
    from app.cli.experiment import interference as run

    with reported_errors():
        run(seeds, as_json=json, plots=plots)


@experiments.command()
def sweep(
    world: World = None,
    seeds: Annotated[int, typer.Option(min=1, help="Count of missions, one per seed.")] = 20,
    goals: Annotated[int, typer.Option(min=1, help="Goals per mission, drawn by the seed.")] = 1,
    goal: Annotated[
        list[str] | None, typer.Option(help="Goal of every mission, instead of drawn ones; repeatable.")
    ] = None,
    first: Annotated[int, typer.Option(min=0, help="First seed.")] = 0,
    pack: PackNames = None,
    jobs: Annotated[int | None, typer.Option(min=1, help="Processes (default: one per core).")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print only one JSON document.")] = False,
) -> None:
    """Measure how often goals come true: plan and simulate a mission per seed and check the simulation's ground truth.

    Prints a row per seed, then the rate with its 95 % interval, times, and failures by packet and reason. Exits with 0
    when all seeds were run, whatever their outcome.
    """
    from app.cli.sweep import SweepRequest
    from app.cli.sweep import sweep as run

    with reported_errors():
        packs = packs_of(pack)
        request = SweepRequest(
            world=named_world(world, packs), packs=packs, sentences=tuple(goal or ()), goals=goals
        )
        run(request, range(first, first + seeds), jobs=jobs or os.cpu_count() or 1, as_json=json)
