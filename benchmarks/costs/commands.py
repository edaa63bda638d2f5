"""Costs of commands that end by themselves, and of an installation."""

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from subprocess import run as run_command
from tempfile import TemporaryDirectory

from benchmarks.costs.table import Row
from benchmarks.databases import SERVER
from benchmarks.posting import service_on
from benchmarks.processes import environment, run

MACTA = (sys.executable, "-c", "from app.cli import main; main()")
DEMO = (*MACTA, "demo", "--flat-out")
INSTALLATIONS: Mapping[str, tuple[Callable[[str], Sequence[str]], float, str]] = {
    "main job": (lambda _: ("uv", "sync", "--quiet"), 650.0, "1394"),
    "production": (lambda folder: ("sh", "examples/install_production.sh", folder), 450.0, "1008"),
}
PROJECT = Path(__file__).parents[2]


def demo(runs: int) -> Iterator[Row]:
    """The main job, each time first with an empty cache of compiled code, then with what the first run left."""
    cold, warm = [], []
    for _ in range(runs):
        with TemporaryDirectory() as folder:
            cold.append(run(DEMO, environment=environment(Path(folder))))
            warm.append(run(DEMO, environment=environment(Path(folder))))
    yield Row(what="demo, first run", unit="CPU-s", values=[r.cpu_s for r in cold], target=20, before="130")
    yield Row(what="demo, first run", unit="s", values=[r.wall_s for r in cold])
    yield Row(what="demo, second run", unit="CPU-s", values=[r.cpu_s for r in warm], target=8, before="27")
    yield Row(what="demo, second run", unit="s", values=[r.wall_s for r in warm])


def calls(runs: int) -> Iterator[Row]:
    """Commands that should import little; `alive` asks a running service's database."""
    yield _call("macta --help", ("--help",), runs, before="2.1")
    yield _call("macta world validate", ("world", "validate", "sample_store"), runs)
    with service_on(SERVER) as served:
        variables = {
            name: value
            for name, value in _environment_of(served.process.pid).items()
            if name.startswith("MACTA_")
        }
        yield _call("macta alive worker", ("alive", "worker"), runs, before="3.4", **variables)


def _call(what: str, arguments: tuple[str, ...], runs: int, before: str = "", **variables: str) -> Row:
    its_own = environment() | variables
    took = [run((*MACTA, *arguments), environment=its_own).cpu_s for _ in range(runs)]
    return Row(what=what, unit="CPU-s", values=took, target=0.4, before=before)


def _environment_of(pid: int) -> Mapping[str, str]:
    entries = Path(f"/proc/{pid}/environ").read_text().split("\0")
    return dict(entry.split("=", 1) for entry in entries if "=" in entry)


def size(runs: int) -> Iterator[Row]:
    """Installed megabytes of fresh environments, without compiled code; once, whatever `runs` says."""
    for what, (command, target, before) in INSTALLATIONS.items():
        with TemporaryDirectory() as folder:
            venv = Path(folder) / "venv"
            run(
                command(str(venv)),
                environment=environment(UV_PROJECT_ENVIRONMENT=str(venv), UV_LINK_MODE="copy"),
                folder=PROJECT,
            )
            said = run_command(["du", "-sm", str(venv)], capture_output=True, text=True, check=True).stdout
        yield Row(
            what=f"installed, {what}",
            unit="MB",
            values=[float(said.split()[0])],
            target=target,
            before=before,
        )
