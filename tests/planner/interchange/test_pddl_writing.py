"""What we write, other planners read and solve; their plans are plans of ours."""

import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from planner import Fact, GroundAction, KnowledgeBase, PlanningProblem
from planner.interchange.pddl import Form, PddlTask, Vocabulary, domain_text, problem_text
from planner.interchange.up_lock import UNIFIED_PLANNING_LOCK
from planner.plan_nets.extraction import fault_of
from tests.planner.store import inside, small_store, store_problem

STORING = store_problem([inside("sample_1", "bay_7")], samples={"sample_1": "door_1"})
SMALL = store_problem([inside("sample_1", "bay_2")], samples={"sample_1": "door_1"}, world=small_store())
STEP = re.compile(r"^(?:[\d.]+:\s*)?\(([^)]*)\)\s*(?:\[([\d.]+)\])?", re.MULTILINE)


def steps(plan: str, task: PddlTask) -> list[tuple[GroundAction, float]]:
    """The ground actions of a plan file with the durations in it."""
    found = []
    for name, *objects, duration in ((*m[1].split(), m[2] or "0") for m in STEP.finditer(plan)):
        found.append((task.ground(name, objects), float(duration)))
    return found


@pytest.mark.parametrize("form", [Form.TEMPORAL, Form.CLASSICAL])
def test_lpg_finds_plans_that_are_plans_of_ours(
    knowledge_base: KnowledgeBase, tmp_path: Path, form: Form
) -> None:
    spec = find_spec("up_lpg")
    if spec is None or spec.origin is None:
        pytest.skip("LPG is not installed")
    task = PddlTask(knowledge_base, STORING, form)
    task.write(tmp_path)
    command = [str(Path(spec.origin).parent / "lpg"), "-o", "domain.pddl", "-f", "problem.pddl"]
    limits = ["-n", "1", "-seed", "1", "-cputime", "60", "-out", "plan"]
    subprocess.run([*command, *limits], cwd=tmp_path, capture_output=True, timeout=100, check=False)
    found = steps((tmp_path / "plan").read_text(), task)
    assert fault_of([action for action, _ in found], STORING.facts, STORING.goals) is None
    if form is Form.TEMPORAL:
        assert all(action.duration_s == pytest.approx(duration, abs=0.01) for action, duration in found)


def test_unified_planning_reads_costs_as_the_actions_costs(knowledge_base: KnowledgeBase) -> None:
    from unified_planning.io import PDDLReader

    texts = written(knowledge_base, Form.CLASSICAL, SMALL)
    with UNIFIED_PLANNING_LOCK:
        read = PDDLReader().parse_problem_string(*texts)
    (metric,) = read.quality_metrics
    assert metric.is_minimize_action_costs()
    assert not any(effect.is_increase() for action in read.actions for effect in action.effects)


def written(
    knowledge_base: KnowledgeBase, form: Form = Form.TEMPORAL, problem: PlanningProblem = STORING
) -> tuple[str, str]:
    """Domain and problem."""
    words = Vocabulary(knowledge_base, form)
    return domain_text(words), problem_text(words, problem)


def translated(folder: Path) -> str:
    """The task that Fast Downward's translator makes of the folder's files."""
    spec = find_spec("up_fast_downward")
    assert spec is not None
    assert spec.origin is not None
    binaries = Path(spec.origin).parent / "downward" / "builds" / "release" / "bin"
    command = [sys.executable, "-m", "fast_downward.translate", "domain.pddl", "problem.pddl"]
    environment = {**os.environ, "PYTHONPATH": str(binaries)}
    answer = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=100, check=False
    )
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return (folder / "output.sas").read_text()


def test_fast_downward_reads_it_and_grounds_no_more_than_ours(
    knowledge_base: KnowledgeBase, tmp_path: Path
) -> None:
    task = PddlTask(knowledge_base, STORING, Form.CLASSICAL)
    task.write(tmp_path)
    operators = re.findall(
        r"begin_operator\n(\S+) ?(.*)\n(?:.*\n)*?(\d+)\nend_operator", translated(tmp_path)
    )
    assert len(operators) > 100
    for name, objects, cost in operators:
        assert round(task.ground(name, objects.split()).duration_s * 10) == int(cost)


def test_a_goal_that_only_comes_about_by_the_way_stays_out_of_reach(
    knowledge_base: KnowledgeBase, tmp_path: Path
) -> None:
    problem = store_problem([Fact("vacant", ("bay_9",))], samples={"sample_1": "bay_9"})
    PddlTask(knowledge_base, problem, Form.CLASSICAL).write(tmp_path)
    assert "begin_operator" not in translated(tmp_path)  # the translator sees that it is unsolvable


def test_an_external_reader_takes_the_temporal_domain(knowledge_base: KnowledgeBase) -> None:
    from unified_planning.io import PDDLReader

    texts = written(knowledge_base, problem=SMALL)
    with UNIFIED_PLANNING_LOCK:
        read = PDDLReader().parse_problem_string(*texts)
    assert {action.name for action in read.actions} == {op.name for op in knowledge_base.operators}
    assert len(read.all_objects) == len(SMALL.objects) + len(knowledge_base.constants)


def test_keywords_and_strange_names_become_names_that_readers_take(knowledge_base: KnowledgeBase) -> None:
    words = Vocabulary(knowledge_base, Form.TEMPORAL)
    assert words.objects["at"] == "at_"
    assert words.types["object"] == "object_"
    assert [words.objects.add(name) for name in ("Bay 7", "bay_7", "7", "TRANSPORT")] == [
        *("bay_7", "bay_7_", "x7", "transport")
    ]
    assert words.objects.original("BAY_7") == "Bay 7"


def test_the_duration_of_a_team_is_a_table(knowledge_base: KnowledgeBase) -> None:
    domain, problem = written(knowledge_base)
    assert "(= ?duration (duration_transport_long_object_at ?ref1 ?ref2 ?robots_1 ?robots_2))" in domain
    assert "(= (duration_transport_long_object_at door_1 interchange_1 yard_1 yard_2) " in problem
    assert "(at start (not (idle_robot ?robots_2)))" in domain


def test_the_text_is_the_same_each_time(knowledge_base: KnowledgeBase) -> None:
    assert written(knowledge_base) == written(knowledge_base)
