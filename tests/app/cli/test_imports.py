"""What each entry point loads: only its own part, counted in modules."""

import json
import os
import subprocess
import sys

import pytest

PHYSICS = {"pybullet"}
SIMULATION = {*PHYSICS, "sim"}
COMPILER = {"numba", "scipy"}
PLANNER = {"unified_planning", "planner.engines.registry"}
ROBOT = {"robots.repertoire", "robots.executive", "numpy"}
DATABASE = {"sqlalchemy", "dbos", "alembic"}
SERVER = {"fastapi", "starlette", "uvicorn"}
HELP = "from app.cli.main import app; app(['--help'], standalone_mode=False)"
VALIDATE = "from app.cli.main import app; app(['world', 'validate', 'sample_store'], standalone_mode=False)"
WORKER_ALIVE = """
import os
os.environ["MACTA_DATABASE_URL"] = "postgresql://nobody@127.0.0.1:1/nothing"
from app.cli.main import app
app(["alive", "worker"], standalone_mode=False)
"""
FLEET_ALIVE = """
import os, app.cli.alive
os.environ["MACTA_BROKER_URL"] = "mqtt://127.0.0.1:1"
app.cli.alive.TIMEOUT_S = 0.0
from app.cli.main import app
app(["alive", "fleet"], standalone_mode=False)
"""
PLANNING = "import app.cli, app.planning.pool.process, planner.engines.registry"
WITHOUT_COVERAGE = "sys.modules['coverage'] = None"
"""Numba imports it where it is installed, as it is for `benchmarks.mutants`."""
NOT_OURS = {"coverage", "sitecustomize"}
"""Debian's interpreter imports the second as it starts."""
WORLD = "import app.cli, sim.process.world_loop, sim.process.persistence, sim.world.agents"


@pytest.mark.parametrize(
    ("statement", "forbidden", "budget"),
    [
        pytest.param(
            HELP,
            SIMULATION | COMPILER | ROBOT | DATABASE | SERVER | {"planner", "pydantic", "robots"},
            350,
            id="help",
        ),
        pytest.param(
            VALIDATE,
            SIMULATION
            | COMPILER
            | PLANNER
            | DATABASE
            | SERVER
            | {"numpy", "pydantic_settings", "robots.repertoire"},
            401,
            id="world validate",
        ),
        pytest.param(
            WORKER_ALIVE,
            SIMULATION | COMPILER | ROBOT | DATABASE | SERVER | {"planner", "pydantic_settings", "robots"},
            470,
            id="alive worker",
        ),
        pytest.param(
            FLEET_ALIVE,
            SIMULATION | COMPILER | ROBOT | DATABASE | SERVER | {"planner"},
            500,
            id="alive fleet",
        ),
        pytest.param(
            "import app.cli.main, app.cli.serve",
            PHYSICS | COMPILER | PLANNER | {"fastapi", "dbos", "alembic"},
            1061,
            id="serve, before it listens",
        ),
        pytest.param(
            "import app.cli.main, app.cli.serve, app.composition",
            PHYSICS | COMPILER | PLANNER | {"alembic"},
            1668,
            id="service",
        ),
        pytest.param(PLANNING, SIMULATION | DATABASE | SERVER, 770, id="planning process"),
        pytest.param(
            WORLD, DATABASE | SERVER | {"planner", "unified_planning", "lark"}, 598, id="world's process"
        ),
    ],
)
def test_an_entry_point_loads_its_own_part_only(statement: str, forbidden: set[str], budget: int) -> None:
    script = f"import json, sys\n{WITHOUT_COVERAGE}\n{statement}\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    loaded = set(json.loads(done.stdout.splitlines()[-1])) - NOT_OURS
    assert forbidden.isdisjoint(loaded), sorted(forbidden.intersection(loaded))
    assert len(loaded) <= budget


PLAN = """
import atexit, sys
from app.cli import main
sys.argv = ["macta", "plan", "--json", "--goal", "move sample_1 to bay_7"]
atexit.register(lambda: print("numba" in sys.modules))
main()
"""


COMPILE = """
from robots.kernels import install
install()
from app.planning.pool.work import PLANNER
from robots.compilation import compile_once
compile_once(PLANNER, print)
"""


def test_what_runs_uncompiled_plans_the_same_without_numba() -> None:
    # NOTE: a small problem is planned uncompiled while nothing is compiled, whatever the switch says.
    compiling = {**os.environ, "NUMBA_DISABLE_JIT": "0"}
    subprocess.run([sys.executable, "-c", COMPILE], check=True, env=compiling)
    plans = []
    for disabled in ("0", "1"):
        done = subprocess.run(
            [sys.executable, "-c", PLAN],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "NUMBA_DISABLE_JIT": disabled},
        )
        plan, _, has_numba = done.stdout.rstrip().rpartition("\n")
        plans.append({name: value for name, value in json.loads(plan).items() if name != "planning_s"})
        assert has_numba == str(disabled == "0")
    assert plans[0] == plans[1]
