"""`macta soak`: a long trial of the service under random goals and faults, judged by the simulated world's truth."""

import random
import secrets
import shutil
import tempfile
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from app.cli.ground_truth import holds, snapshot_truth
from app.soak import Faults, Installation, Quiet, Trial
from app.soak.trial import Real
from robots.world import WorldFile, world_yaml
from sim.error import SimulationError

STORM_S = (30.0, 90.0)
"""How long goals and faults go on between two quiet points; wall clock."""
OUT_S, EVERY_S = (20.0, 60.0), (200.0, 400.0)
"""How long each robot is out of contact, and how often; the world's clock."""
PUSH_M = 0.15
SHOWN = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Wish:
    """What to try, and how. `minutes` counts to the last round's beginning of its quiet."""

    world: WorldFile
    minutes: float
    seed: int
    speed: float
    database_url: str | None = None


def soak(wish: Wish) -> int:
    """Run the trial; 0 if all held, else 1, and the folder with what was said and recorded is kept."""
    console = Console(highlight=False, soft_wrap=True)
    folder = Path(tempfile.mkdtemp(prefix="macta-soak-"))
    world = with_outages(wish.world, random.Random(wish.seed))
    (folder / "world.yaml").write_text(world_yaml(world))
    installation = Installation(
        data=folder / "data",
        world=str(folder / "world.yaml"),
        token=secrets.token_urlsafe(32),
        speed=wish.speed,
        environment={} if wish.database_url is None else {"MACTA_DATABASE_URL": wish.database_url},
    )
    console.print(
        f"[bold]Macta[/]: {world.name} at {wish.speed:g}× for {wish.minutes:g} min, seed {wish.seed}; in {folder}"
    )
    trial = Trial(
        installation=installation,
        world=world,
        seed=wish.seed,
        real=lambda: real(installation.data, world),
        faults=Faults(installation, wish.seed, lambda rng: push_one(installation.data, world, rng)),
    )
    _run(trial, wish, console)
    _show(trial, console)
    if not trial.wrong:
        shutil.rmtree(folder)
        return 0
    console.print(f"[bold red]Not all held[/] (seed {wish.seed}); what was said and recorded is in {folder}")
    return 1


def with_outages(world: WorldFile, rng: random.Random) -> WorldFile:
    """The world with radios that fall silent, each robot's at times of its own."""

    def outage() -> Mapping[str, float]:
        start_s, out_s = rng.uniform(10.0, 200.0), rng.uniform(*OUT_S)
        return {"start_s": start_s, "end_s": start_s + out_s, "every_s": rng.uniform(*EVERY_S)}

    told = world.model_dump(mode="json", exclude_defaults=True)
    for robot in told["robots"]:
        robot["link"] = {**(robot.get("link") or {}), "outages": [outage()]}
    return WorldFile.model_validate(told)


def real(data: Path, world: WorldFile) -> Real:
    """The world as it was kept last."""
    truth = snapshot_truth(data, world)
    return Real(
        is_true=lambda fact: holds(fact, world, truth),
        lies={name: sample.ref for name, sample in truth.samples.items()},
    )


def push_one(data: Path, world: WorldFile, rng: random.Random) -> str:
    """While nobody simulates the world, somebody pushes a rover in what is kept of it; nothing if there is no room."""
    # NOTE: imported here, for they load the physics.
    from sim.process.snapshot_file import SnapshotFile
    from sim.trials.mishaps import push
    from sim.world.agents import behavioural_agent
    from sim.world.simulation import Simulation

    try:
        with SnapshotFile(data / "worlds" / f"{world.name}.json") as file:
            simulation = Simulation(world, make_agent=behavioural_agent, snapshot=file.read(world))
            ahead_m, left_m = (rng.uniform(-PUSH_M, PUSH_M) for _ in "xy")
            push(simulation, rng.choice(world.robots).name, ahead_m=ahead_m, left_m=left_m)
            file.write(simulation.snapshot())
            simulation.close()
    except (SimulationError, ValueError):
        return ""
    return "rover pushed"


def _run(trial: Trial, wish: Wish, console: Console) -> None:
    rng = random.Random(wish.seed)
    with trial.under_way():
        while trial.elapsed_s < 60.0 * wish.minutes and not trial.wrong:
            left_s = max(60.0 * wish.minutes - trial.elapsed_s, 1.0)
            with console.status("goals and faults …") if console.is_terminal else nullcontext():
                quiet = trial.round(min(rng.uniform(*STORM_S), left_s))
            console.print(_line(trial, quiet))


def _line(trial: Trial, quiet: Quiet) -> str:
    faults = sum(trial.faults.done.values())
    return (
        f"{quiet.at_s:6.0f} s: {quiet.goals} goals, {faults} faults, life {quiet.life}, {quiet.memory_mb:.0f} MiB: "
        + ("all held" if not quiet.wrong else f"[red]{len(quiet.wrong)} did not hold[/]")
    )


def _show(trial: Trial, console: Console) -> None:
    outcomes: dict[str, int] = {}
    for goal in trial.watch.goals.values():
        name = f"goals {goal['state']}: {goal['outcome']}"
        outcomes[name] = outcomes.get(name, 0) + 1
    counts = {**trial.operator.done, **trial.faults.done, **outcomes}
    table = Table(box=SIMPLE_HEAD)
    table.add_column("What was done, and what came of it")
    table.add_column("Times", justify="right")
    for name, count in counts.items():
        table.add_row(escape(name), str(count))
    console.print(table)
    for words in trial.wrong[:SHOWN]:
        console.print(f"[red]{escape(words)}[/]")
