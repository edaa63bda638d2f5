"""The commands and their options. Each command's work lies in a module of its own, imported when it is called."""

import os
from pathlib import Path
from typing import Annotated

import typer

from app.cli import production
from app.cli.options import Broker, Speed, World, Worlds, carefully, fail, leave, named_world, named_worlds
from planner import Objective, PlanningRequest, load_knowledge_base
from robots.world import WorldFile

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Plans goals for teams of robots, has them approved, and sees them carried out.",
)
worlds = typer.Typer(no_args_is_help=True, help="World files: make and check them, print their schema.")
app.add_typer(worlds, name="world")
experiments = typer.Typer(no_args_is_help=True, help="Experiments on the simulated robots, over many seeds.")
app.add_typer(experiments, name="experiment")
app.command()(production.fleet)
app.command()(production.worker)
app.add_typer(production.alive, name="alive")


@app.command()
def serve(
    world: Worlds = None,
    speed: Speed = 1.0,
    host: Annotated[str | None, typer.Option(help="Address to listen on; loopback unless told.")] = None,
    port: Annotated[int | None, typer.Option(min=0, max=65535, help="0: any free one. Default 8000.")] = None,
    data: Annotated[Path | None, typer.Option(help="Folder of the record. Default ./macta-data.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the simulation's noise.")] = 0,
    broker: Broker = None,
    afresh: Annotated[bool, typer.Option("--afresh", help="Build the world anew; else it goes on.")] = False,
) -> None:
    """Serve the HTTP API and the operator's page; worlds are simulated here or, given a broker, by `macta fleet`."""
    from app.cli.serve import serve as run

    given = {"host": host, "port": port, "data": data, "broker_url": broker}
    with carefully():
        run(
            named_worlds(world),
            speed or 1.0,
            seed,
            {k: v for k, v in given.items() if v is not None},
            afresh=afresh,
        )
    leave(0)


@app.command()
def demo(
    world: World = "sample_store",
    goal: Annotated[str, typer.Option(help="What to achieve.")] = "move sample_1 to bay_7",
    speed: Annotated[float | None, typer.Option(min=0.01, help="World seconds a second.")] = 4.0,
    flat_out: Annotated[
        bool, typer.Option(help="As fast as the machine can, whatever --speed says.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of start poses and noise.")] = 0,
) -> None:
    """Run the main job in the terminal: a goal becomes a plan, is approved, and the rovers carry it out."""
    from app.cli.demo import demo as run

    with carefully():
        leave(run(named_world(world), goal, None if flat_out else speed, seed))


@app.command()
def plan(
    goal: Annotated[
        list[str] | None, typer.Option(help="What to achieve; may be given several times.")
    ] = None,
    world: World = "sample_store",
    time_limit: Annotated[float, typer.Option(min=0.1, help="Seconds the planner may take.")] = 30.0,
    effort: Annotated[
        float | None, typer.Option(min=0, help="Seconds to improve the first plan; left out: by its size.")
    ] = None,
    objective: Annotated[Objective, typer.Option(help="What to have little of.")] = Objective.MAKESPAN,
    deadline: Annotated[float | None, typer.Option(help="Seconds by which every goal is to be true.")] = None,
    engine: Annotated[
        str, typer.Option(help="All that are installed, in turn, or one by name; a wrong name lists them.")
    ] = "portfolio",
    json: Annotated[
        bool, typer.Option("--json", help="Print the plan body as JSON, and nothing else.")
    ] = False,
    alternatives: Annotated[
        int, typer.Option(min=0, max=20, help="Compare so many plans that really differ.")
    ] = 0,
    explain: Annotated[bool, typer.Option("--explain", help="Say why the plan is as it is.")] = False,
    knowledge_base: Annotated[
        Path | None, typer.Option(help="A knowledge base of your own, for the same world.")
    ] = None,
    pddl: Annotated[Path | None, typer.Option(help="Folder to write the problem to as PDDL.")] = None,
    domain: Annotated[Path | None, typer.Option(help="A PDDL domain to plan with, not a world.")] = None,
    problem: Annotated[Path | None, typer.Option(help="The PDDL problem of that domain.")] = None,
    agent: Annotated[
        list[str] | None,
        typer.Option(help="A type of agents in the PDDL domain; left out: actions' first parameters."),
    ] = None,
) -> None:
    """Plan only, no server: print the plan-net for a goal. Ctrl-C takes the best plan so far."""
    from app.cli.beside import Wanted
    from app.cli.plan import plan as run
    from app.cli.plan import plan_pddl

    wanted = Wanted(alternatives=alternatives, explanation=explain)
    with carefully():
        request = PlanningRequest(time_limit_s=time_limit, effort_s=effort, objective=objective)
        if domain and problem and not (goal or pddl or knowledge_base or deadline):
            given = (domain, problem, agent or [], request)
            raise typer.Exit(plan_pddl(*given, engine_name=engine, as_json=json, wanted=wanted))
        if domain or problem or agent or not goal:
            fail("give --goal, or --domain and --problem with --agent if need be")
        base = load_knowledge_base(knowledge_base)
        raise typer.Exit(
            run(
                named_world(world, base),
                base,
                goal,
                request,
                engine_name=engine,
                as_json=json,
                wanted=wanted,
                deadline_s=deadline,
                pddl=pddl,
            )
        )


@app.command()
def soak(
    minutes: Annotated[float, typer.Option(min=0.1, help="How long; the last quiet comes on top.")] = 10.0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of goals and faults.")] = 0,
    world: World = "sample_store",
    speed: Speed = 6.0,
    database_url: Annotated[
        str | None, typer.Option(help="Database of the service under trial; one in a folder unless told.")
    ] = None,
) -> None:
    """Try a service of its own: random goals, kills and outages; then what it says is compared with the world's truth.

    Ends with 0 only if all held. `MACTA_…` variables are not handed on to the service under trial.
    """
    from app.cli.soak import Wish
    from app.cli.soak import soak as run

    with carefully():
        wish = Wish(
            world=named_world(world),
            minutes=minutes,
            seed=seed,
            speed=speed or 6.0,
            database_url=database_url,
        )
        raise typer.Exit(run(wish))


@worlds.command()
def validate(
    file: Annotated[str, typer.Argument(help="A world that ships with Macta, or a world file.")],
) -> None:
    """Check a world file; the error names the slot and the choices."""
    with carefully():
        world = named_world(file)
    robots, places, samples = len(world.robots), len(world.locations), len(world.samples)
    berths = [len(row) for row in world.rows.values() if len(row) > 1]
    told = f" ({len(berths)} of them with {sum(berths)} berths)" if berths else ""
    typer.echo(f"{world.name}: valid; {robots} robots, {places} locations{told}, {samples} samples")


Count = Annotated[int | None, typer.Option(min=0, help="How many; left out: by the other numbers.")]


@worlds.command()
def generate(
    aisles: Count = None,
    store_robots: Count = None,
    yard_robots: Count = None,
    interchanges: Count = None,
    doors: Count = None,
    bays: Count = None,
    samples: Annotated[int, typer.Option(min=0, help="How many; aisles and robots go by it.")] = 4,
    compartments: Annotated[int, typer.Option(min=2, help="The yard and the stores behind it.")] = 2,
    bay_capacity: Annotated[
        int, typer.Option(min=1, max=100, help="Samples that each bay has room for.")
    ] = 1,
    seed: Annotated[int, typer.Option(min=0, help="Seed of where the samples lie.")] = 0,
    out: Annotated[Path | None, typer.Option(help="File to write; standard output unless told.")] = None,
) -> None:
    """Write a world file of a sample store of any size."""
    from app.cli.generate import generate as run

    given = {"aisles": aisles, "store_robots": store_robots, "yard_robots": yard_robots}
    given |= {"interchanges": interchanges, "doors": doors, "bays": bays, "bay_capacity": bay_capacity}
    with carefully():
        run(samples, compartments, given, seed, out)


@worlds.command()
def schema() -> None:
    """Print the JSON Schema of world files."""
    import json

    typer.echo(json.dumps(WorldFile.model_json_schema(), indent=2))


@experiments.command()
def interference(
    seeds: Annotated[int, typer.Option(min=1, help="Ways to the door for each cell of the table.")] = 10,
    json: Annotated[bool, typer.Option("--json", help="Print the rows as JSON, and nothing else.")] = False,
    plots: Annotated[
        Path, typer.Option(help="Folder to write the figures to, one way to the door each, as SVG.")
    ] = Path("macta-figures"),
) -> None:
    """Things are put in a robot's way to the kitchen door: parallel against sequential sensing (P-SMPA, section 6).

    Prints table 1 (how many of them were noticed, and the time the way took) and writes figures like 5 and 6.
    """
    from app.cli.experiment import interference as run

    with carefully():
        run(seeds, as_json=json, plots=plots)


@experiments.command()
def sweep(
    world: World = "sample_store",
    seeds: Annotated[int, typer.Option(min=1, help="How many missions; a seed each.")] = 20,
    goals: Annotated[int, typer.Option(min=1, help="How many goals a mission, drawn by the seed.")] = 1,
    goal: Annotated[
        list[str] | None, typer.Option(help="This goal each time, none drawn; may be given several times.")
    ] = None,
    first: Annotated[int, typer.Option(min=0, help="The first seed.")] = 0,
    jobs: Annotated[int | None, typer.Option(min=1, help="Processes; left out: one a core.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON document, and nothing else.")] = False,
) -> None:
    """How often goals come true: planned, and carried out flat out in the simulated world, whose truth is the judge.

    A row a seed, then the rate with its 95 % interval, times, and failures by packet and reason. Ends with 0 when all
    seeds were run, whatever became of them.
    """
    from app.cli.sweep import Plot
    from app.cli.sweep import sweep as run

    with carefully():
        plot = Plot(world=named_world(world), sentences=tuple(goal or ()), goals=goals)
        run(plot, range(first, first + seeds), jobs=jobs or os.cpu_count() or 1, as_json=json)
