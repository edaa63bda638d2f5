"""unified-planning's import without ConfigSpace."""

import subprocess
import sys

LIGHT = """
import sys
from planner.interchange.up_import import import_unified_planning
import_unified_planning()
assert "scipy" not in sys.modules, "what made the import slow"
import ConfigSpace
assert hasattr(ConfigSpace, "Categorical"), "the stand-in is gone again"
from unified_planning.shortcuts import BoolType, Fluent, InstantaneousAction, OneshotPlanner, Problem
lit = Fluent("lit", BoolType())
light = InstantaneousAction("light")
light.add_effect(lit, True)
problem = Problem("lamp")
problem.add_fluent(lit, default_initial_value=False)
problem.add_action(light)
problem.add_goal(lit)
with OneshotPlanner(name="fast-downward") as planner:
    print(planner.solve(problem).status.name)
"""
WHOLE = """
import ConfigSpace
from planner.interchange.up_import import import_unified_planning
import_unified_planning()
from unified_planning.engines import Engine
print(type(Engine.get_configuration_space()) is ConfigSpace.ConfigurationSpace)
"""


def said(script: str) -> str:
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[-1]


def test_unified_planning_works_without_configspace_and_its_scipy() -> None:
    assert said(LIGHT).endswith("SOLVED_SATISFICING")


def test_a_program_that_imports_configspace_itself_has_the_real_one() -> None:
    assert said(WHOLE) == "True"
