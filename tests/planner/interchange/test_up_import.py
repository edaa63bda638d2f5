"""unified-planning's import without ConfigSpace."""

import subprocess
import sys

import pytest

ABSENT = """
import sys
from importlib.abc import MetaPathFinder

class Absent(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("ConfigSpace", "scipy"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Absent())
"""
"""As in the environment of a checkout."""
PLANNER = """
from planner.interchange.up_import import import_unified_planning
import_unified_planning()
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
REGISTRATION = """
from planner import register_with_unified_planning
register_with_unified_planning()
from unified_planning.shortcuts import OneshotPlanner
with OneshotPlanner(name="macta") as planner:
    print(planner.name)
"""
PDDL = """
from planner.interchange.foreign import import_domain
print(import_domain('''
(define (domain lamps) (:requirements :strips :typing) (:types robot lamp) (:predicates (lit ?l - lamp))
  (:action light :parameters (?r - robot ?l - lamp) :effect (lit ?l)))''').actions[0].name)
"""
VALIDATION = """
from planner import load_knowledge_base
from planner.engines.plan_net_completion import warm_up_validation
warm_up_validation(load_knowledge_base())
print("valid")
"""
WHOLE = """
import ConfigSpace
from planner.interchange.up_import import import_unified_planning
import_unified_planning()
from unified_planning.engines import Engine
print(type(Engine.get_configuration_space()) is ConfigSpace.ConfigurationSpace)
"""
AFTERWARDS = """
from planner.interchange.up_import import import_unified_planning
import_unified_planning()
assert "scipy" not in sys.modules, "what made the import slow"
import ConfigSpace
print(hasattr(ConfigSpace, "Categorical"))
"""


def said(script: str) -> str:
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()[-1]


@pytest.mark.parametrize(
    ("script", "answer"),
    [
        pytest.param(PLANNER, "SOLVED_SATISFICING", id="its own planners"),
        pytest.param(REGISTRATION, "macta", id="Macta as one of them"),
        pytest.param(PDDL, "LIGHT", id="its reader"),
        pytest.param(VALIDATION, "valid", id="its validator"),
    ],
)
def test_what_is_used_of_unified_planning_works_where_configspace_is_not_installed(
    script: str, answer: str
) -> None:
    assert said(ABSENT + script).endswith(answer)


def test_the_stand_in_is_gone_after_the_import() -> None:
    assert said(f"import sys\n{AFTERWARDS}") == "True"


def test_a_program_that_imports_configspace_itself_has_the_real_one() -> None:
    assert said(WHOLE) == "True"
