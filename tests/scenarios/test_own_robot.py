"""The robots' software alone, in a clean environment: a body of one's own does the main job on the broker."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.mosquitto import Mosquitto, mosquitto, needs_mosquitto
from tests.scenarios.serving import macta_serve
from tests.waiting import read_until

ROOT = Path(__file__).parents[2]
WORLD = ROOT / "examples" / "own_robot.yaml"
TOKEN = "a-token-of-the-test-that-is-long-enough"
MAX_MB = 72.0
"""With numpy, 59 of them. What the parts take is in docs/runtime.md."""


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of an environment with the wheel of the robots' software, and nothing else of ours."""
    uv = shutil.which("uv") or os.environ.get("UV")
    assert uv is not None, "uv is needed to build the wheel"
    folder = tmp_path_factory.mktemp("robots")
    environment = folder / "env"
    wheels = folder / "wheels"
    for command in (
        ["build", "--package", "macta-robots", "--wheel", "--out-dir", wheels],
        ["venv", "--python", sys.executable, environment],
    ):
        subprocess.run([uv, *command], cwd=ROOT, check=True, capture_output=True)
    (wheel,) = wheels.glob("*.whl")
    assert wheel.name.endswith("-py3-none-any.whl")
    found = environment / "bin" / "python"
    wanted = f"macta-robots[agent] @ {wheel.as_uri()}"
    # From the checkout: of the committed versions.
    subprocess.run(
        [uv, "pip", "install", "--python", found, wanted], cwd=ROOT, check=True, capture_output=True
    )
    return found


def test_the_robots_software_is_installed_without_the_service_and_is_small(python: Path) -> None:
    installed = {
        path.name for path in (python.parents[1]).glob("lib/python*/site-packages/*") if path.is_dir()
    }
    assert installed.isdisjoint({"app", "planner", "sim", "web", "numba", "llvmlite", "pybullet", "fastapi"})
    assert {"robots", "numpy", "paho"} <= installed
    files = (path for path in python.parents[1].rglob("lib/python*/site-packages/**/*") if path.is_file())
    assert sum(path.stat().st_size for path in files if path.suffix != ".pyc") < MAX_MB * 1e6


@contextmanager
def robot(python: Path, broker: Mosquitto, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    with (folder / "robot.log").open("wb") as log:
        process = subprocess.Popen(
            [python, "-I", ROOT / "examples" / "own_robot.py", broker.url, WORLD, "carl"],
            cwd=folder,
            stdout=log,
            stderr=log,
        )
        try:
            yield process
        finally:
            process.kill()
            process.wait()


@needs_mosquitto
def test_a_body_of_ones_own_does_the_main_job(python: Path, tmp_path: Path) -> None:
    with (
        mosquitto(tmp_path / "broker") as broker,
        robot(python, broker, tmp_path) as process,
        macta_serve(tmp_path / "data", "--world", str(WORLD), broker_url=broker.url, token=TOKEN) as served,
        served.client() as api,
    ):
        goal = {"text": "bring sample_1 to bay_2", "world": "workshop", "auto_approve": True}
        made = api.post("/v1/goals", json=goal)
        assert made.status_code == 202, made.text
        goal_path = f"/v1/goals/{made.json()['id']}"
        ended = read_until(api, goal_path, lambda read: read["outcome"] is not None, within_s=200)
        assert ended["outcome"] == "completed", (ended, (tmp_path / "robot.log").read_text())
        assert process.poll() is None
