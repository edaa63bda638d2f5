"""Things that no goal names count as one, and what is out of reach stays the same."""

from dataclasses import replace
from random import Random

import pytest

from benchmarks.planner.instances import FAMILIES
from planner import Fact, load_knowledge_base
from planner.relaxation import Relaxation, unreachable_goals
from planner.relaxation.reachability import with_bystanders_merged
from tests.planner.store import inside, store_problem

BASE = load_knowledge_base()


def test_one_sample_stands_for_all_that_no_goal_names() -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    merged = with_bystanders_merged(BASE, problem)
    assert {name for name in merged.objects if name.startswith("sample")} == {"sample_1", "sample_2"}
    lying = {fact.args[2] for fact in merged.facts if fact.args[0] == "sample_2"}
    assert lying == {f.args[2] for f in problem.facts if f.predicate == "object_position"} - {"door_1"}


def test_things_that_static_facts_tell_apart_stay_apart() -> None:
    problem = store_problem([inside("sample_1", "bay_7")])
    special = replace(problem, facts=problem.facts | {Fact("solid", ("sample_3",))})
    merged = with_bystanders_merged(BASE, special)
    assert {name for name in merged.objects if name.startswith("sample")} == {
        "sample_1",
        "sample_2",
        "sample_3",
    }


def test_a_problem_without_bystanders_stays_as_it_is() -> None:
    samples = {"sample_1": "door_1"}
    problem = store_problem([inside("sample_1", "bay_7")], samples=samples)
    assert with_bystanders_merged(BASE, problem) is problem


@pytest.mark.parametrize("seed", range(24))
def test_as_much_is_out_of_reach_as_with_every_thing_by_itself(seed: int) -> None:
    random = Random(seed)
    problem = FAMILIES["random"](4, seed).problem(BASE)
    problem = replace(problem, goals=problem.goals[:1])
    statics = sorted(fact for fact in problem.facts if fact.predicate not in BASE.fluents)
    kept = problem.facts - set(random.sample(statics, len(statics) // random.choice((10, 40, 100))))
    problem = replace(problem, facts=kept)
    apart = Relaxation(BASE, problem)
    apart.run()
    is_out_of_reach = apart.missing(problem.goals[0]) is None
    assert bool(unreachable_goals(BASE, problem)) == is_out_of_reach
