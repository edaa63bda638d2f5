"""`macta soak`: a long test of the service under random goals and faults against the simulation's ground truth."""

import random
import secrets
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from app.cli.ground_truth import holds, snapshot_truth
from app.cli.trials.service_faults import ServiceFaults
from app.cli.trials.service_process import Installation
from app.cli.trials.soak import RoundResult, SoakTrial, TrueState
from app.packs.pack_set import Packs
from robots.world import WorldFile, world_yaml
from sim.error import SimulationError

STORM_S = (30.0, 90.0)
"""How long goals and faults go on between two checks (wall clock)."""
OUTAGE_S = (20.0, 60.0)
OUTAGE_INTERVAL_S = (200.0, 400.0)
"""How long each robot is out of contact, and how often (world's clock)."""
PUSH_M = 0.15
SHOWN = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class SoakRequest:
    """What to test. `minutes` is the time until the last check; `packs`: None is `store`, whose goals move samples."""

    world: WorldFile
    minutes: float
    seed: int
    speed: float
    database_url: str | None = None
    packs: Packs | None = None


def soak(request: SoakRequest) -> int:
    """Run the test; 0 if every check passed, else 1, and the folder with logs and database is kept."""
    console = Console(highlight=False, soft_wrap=True)
    folder = Path(tempfile.mkdtemp(prefix="macta-soak-"))
    packs = request.packs
    world = with_outages(request.world, random.Random(request.seed))
    (folder / "world.yaml").write_text(world_yaml(world))
    installation = Installation(
        data=folder / "data",
        world=str(folder / "world.yaml"),
        token=secrets.token_urlsafe(32),
        speed=request.speed,
        environment=_environment(request),
    )
    console.print(
        f"[bold]Macta[/]: {world.name} at {request.speed:g}× for {request.minutes:g} min, "
        f"seed {request.seed}; in {folder}"
    )
    trial = SoakTrial(
        installation=installation,
        world=world,
        seed=request.seed,
        true_state=lambda: true_state(installation.data, world),
        faults=ServiceFaults(
            installation,
            request.seed,
            lambda rng: push_one(installation.data, world, rng, None if packs is None else packs.packets),
        ),
        verbs=None if packs is None else packs.verbs(),
    )
    _run(trial, request, console)
    _show(trial, console)
    if not trial.wrong:
        shutil.rmtree(folder)
        return 0
    console.print(f"[bold red]Checks failed[/] (seed {request.seed}); logs and database are in {folder}")
    return 1


def _environment(request: SoakRequest) -> Mapping[str, str]:
    """The tested service's settings."""
    packs = {"MACTA_PACKS": ",".join(pack.place for pack in request.packs.packs)} if request.packs else {}
    return packs if request.database_url is None else {**packs, "MACTA_DATABASE_URL": request.database_url}


def with_outages(world: WorldFile, rng: random.Random) -> WorldFile:
    """The world with radio outages, at different times for each robot."""

    def outage() -> Mapping[str, float]:
        start_s = rng.uniform(10.0, 200.0)
        out_s = rng.uniform(*OUTAGE_S)
        return {"start_s": start_s, "end_s": start_s + out_s, "every_s": rng.uniform(*OUTAGE_INTERVAL_S)}

    told = world.model_dump(mode="json", exclude_defaults=True)
    for robot in told["robots"]:
        robot["link"] = {**(robot.get("link") or {}), "outages": [outage()]}
    return WorldFile.model_validate(told)


def true_state(data: Path, world: WorldFile) -> TrueState:
    """The ground truth of the world's last snapshot."""
    truth = snapshot_truth(data, world)
    return TrueState(
        # Where robots stand is undone by their next errand, and by their upkeep.
        is_true=lambda fact: holds(fact, world, truth) if fact.args[0] in truth.samples else None,
        lies={name: sample.ref for name, sample in truth.samples.items()},
    )


def push_one(
    data: Path, world: WorldFile, rng: random.Random, packet_files: Sequence[Path] | None = None
) -> str:
    """Push a robot in the snapshot of a world that is not running; returns the fault, empty if there was no room.

    :param packet_files: those of the robots' repertoires; None: what ships.
    """
    # NOTE: imported here, for they load the physics.
    from sim.process.snapshot_file import SnapshotFile
    from sim.trials.mishaps import push
    from sim.world.agents import agents_with
    from sim.world.simulation import Simulation

    try:
        with SnapshotFile(data / "worlds" / f"{world.name}.json") as file:
            simulation = Simulation(world, make_agent=agents_with(packet_files), snapshot=file.read(world))
            ahead_m = rng.uniform(-PUSH_M, PUSH_M)
            left_m = rng.uniform(-PUSH_M, PUSH_M)
            push(simulation, rng.choice(world.robots).name, ahead_m=ahead_m, left_m=left_m)
            file.write(simulation.snapshot())
            simulation.close()
    except (SimulationError, ValueError):
        return ""
    return "rover pushed"


def _run(trial: SoakTrial, request: SoakRequest, console: Console) -> None:
    rng = random.Random(request.seed)
    with trial.under_way():
        while trial.elapsed_s < 60.0 * request.minutes and not trial.wrong:
            left_s = max(60.0 * request.minutes - trial.elapsed_s, 1.0)
            with console.status("goals and faults …") if console.is_terminal else nullcontext():
                result = trial.round(min(rng.uniform(*STORM_S), left_s))
            console.print(_line(trial, result))


def _line(trial: SoakTrial, result: RoundResult) -> str:
    faults = sum(trial.faults.done.values())
    return (
        f"{result.at_s:6.0f} s: {result.goals} goals, {faults} faults, process {result.process}, "
        f"{result.memory_mb:.0f} MiB: "
        + ("all checks passed" if not result.wrong else f"[red]{len(result.wrong)} checks failed[/]")
    )


def _show(trial: SoakTrial, console: Console) -> None:
    outcomes: dict[str, int] = {}
    for goal in trial.observer.goals.values():
        name = f"goals {goal['state']}: {goal['outcome']}"
        outcomes[name] = outcomes.get(name, 0) + 1
    counts = {**trial.operator.done, **trial.faults.done, **outcomes}
    table = Table(box=SIMPLE_HEAD)
    table.add_column("Actions and outcomes")
    table.add_column("Times", justify="right")
    for name, count in counts.items():
        table.add_row(escape(name), str(count))
    console.print(table)
    for words in trial.wrong[:SHOWN]:
        console.print(f"[red]{escape(words)}[/]")
