"""Fragments from a knowledge base that has nothing to do with stores."""

import pytest

from planner import Fact, read_knowledge_base
from planner.engines.hierarchical.fragments.fragment import Fragments
from tests.planner.engines.hierarchical.checks import crew, fragments_of, tags
from tests.planner.engines.hierarchical.survey import SURVEY, survey

PHOTOGRAPHED = Fact("photographed", ("rock",))


@pytest.fixture
def fragments() -> Fragments:
    return Fragments(read_knowledge_base(SURVEY, "survey.yaml"))


def test_a_rover_fetches_its_camera_charges_opens_the_gate_and_photographs(fragments: Fragments) -> None:
    best = fragments_of(fragments, survey([PHOTOGRAPHED], rovers={"ann": "fork"}))[0]
    assert sorted(tags(best)) == sorted(
        ["OPEN", "DRIVE", "TAKE", "CHARGE", "DRIVE", "PASS", "DRIVE", "DRIVE", "PHOTOGRAPH"]
    )


def test_dead_ends_do_not_lead_astray(fragments: Fragments) -> None:
    best = fragments_of(fragments, survey([PHOTOGRAPHED], rovers={"ann": "fork"}, branches=30))[0]
    assert len(best.actions) == 9


def test_a_charged_rover_does_not_charge(fragments: Fragments) -> None:
    problem = survey([PHOTOGRAPHED], rovers={"ann": "base"}, charged=["ann"])
    assert all("CHARGE" not in tags(fragment) for fragment in fragments_of(fragments, problem))


def test_what_was_learnt_uncharged_does_not_make_a_charged_rover_charge(fragments: Fragments) -> None:
    assert fragments_of(fragments, survey([PHOTOGRAPHED], rovers={"ann": "base"}, open_gate=True))
    problem = survey([PHOTOGRAPHED], rovers={"ann": "base"}, charged=["ann"], open_gate=True)
    assert "CHARGE" not in tags(fragments_of(fragments, problem)[0])


def test_a_rover_that_holds_a_spade_changes_it_for_the_camera(fragments: Fragments) -> None:
    problem = survey([PHOTOGRAPHED], rovers={"ann": "base"}, charged=["ann"], tools={"camera": "base"})
    facts = (problem.facts - {Fact("free", ("ann",))}) | {Fact("holds", ("ann", "spade"))}
    problem = type(problem)(
        objects=problem.objects | {"spade": "tool"},
        facts=facts,
        goals=problem.goals,
        functions=problem.functions,
    )
    best = fragments_of(fragments, problem)[0]
    assert tags(best).index("DROP") < tags(best).index("TAKE")


def test_two_strong_rovers_carry_the_box_together(fragments: Fragments) -> None:
    goal = Fact("stands", ("box", "fork"))
    problem = survey([goal], rovers={"ann": "base", "bob": "fork", "cy": "base"}, strong=["ann", "bob"])
    best = fragments_of(fragments, problem)[0]
    assert sorted(tags(best)) == ["CARRY", "DRIVE"]
    assert crew(best) == {"ann", "bob"}


def test_one_strong_rover_is_not_enough(fragments: Fragments) -> None:
    goals = (Fact("stands", ("box", "fork")),)
    problem = survey(goals, rovers={"ann": "base", "bob": "base"}, strong=["ann"])
    source = fragments.of(problem)
    assert source.alternatives(goals) == ()


def test_a_box_that_no_team_gets_through_the_gate_is_not_found(fragments: Fragments) -> None:
    goals = (Fact("stands", ("box", "north")),)
    problem = survey(goals, rovers={"ann": "base", "bob": "base"}, strong=["ann", "bob"])
    source = fragments.of(problem)
    assert source.alternatives(goals) == ()


def test_one_rover_may_open_for_another(fragments: Fragments) -> None:
    """The nearer rover can only reach north once the gate is open; it holds a tool, so it cannot open it."""
    problem = survey([Fact("at", ("ann", "north"))], rovers={"ann": "fork", "bob": "base"}, tools={})
    facts = (problem.facts - {Fact("free", ("ann",))}) | {Fact("holds", ("ann", "spade"))}
    problem = type(problem)(
        objects=problem.objects | {"spade": "tool"},
        facts=facts,
        goals=problem.goals,
        functions=problem.functions,
    )
    found = fragments_of(fragments, problem)
    assert {frozenset(crew(fragment)) for fragment in found} == {
        frozenset({"ann"}),
        frozenset({"ann", "bob"}),
    }


def test_goals_that_come_about_only_by_the_way_are_unreachable(fragments: Fragments) -> None:
    goals = (Fact("warm", ("camera",)),)
    source = fragments.of(survey(goals, rovers={"ann": "base"}))
    assert source.alternatives(goals) == ()


def test_a_cluster_of_two_goals_is_reached_together(fragments: Fragments) -> None:
    goals = [PHOTOGRAPHED, Fact("at", ("ann", "base"))]
    best = fragments_of(fragments, survey(goals, rovers={"ann": "base"}))[0]
    assert tags(best)[-1] == "DRIVE"
    assert "PHOTOGRAPH" in tags(best)


def test_a_cluster_whose_first_goal_holds_but_is_undone_on_the_way(fragments: Fragments) -> None:
    goals = [Fact("at", ("ann", "base")), Fact("lies", ("camera", "ridge"))]
    best = fragments_of(fragments, survey(goals, rovers={"ann": "base"}))[0]
    assert "DROP" in tags(best)
