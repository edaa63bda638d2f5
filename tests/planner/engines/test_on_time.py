"""The objective `on_time`: the plan that most goals are expected to be in time by, not the one shortest in the mean."""

import textwrap
from dataclasses import replace

import pytest

from planner import (
    UNOBSERVED,
    Fact,
    KnowledgeBase,
    Objective,
    Observer,
    PlanNet,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    Progress,
    Spread,
    faults_of,
    read_knowledge_base,
)
from planner.alternatives import alternatives
from planner.engines.registry import engine_named
from planner.plan_nets.completion import forecast

KNOWN = 1000.0


def base() -> KnowledgeBase:
    """Jobs that are DASHed, 10 s, or PLODded, 11 s."""
    ways = "".join(
        textwrap.indent(
            textwrap.dedent(f"""
            - identifier: {number}
              name: {name}
              parameters: [{{name: robot, type: robot}}, {{name: job, type: job}}]
              agents: [robot]
              preconditions: ["can(robot, {name})", "open(job)"]
              delete: ["open(job)"]
              intended_effects: ["done(job)"]
              other_effects: []
              duration: "{takes_s}"
              description: "{{robot}} does {{job}}"
            """),
            "  ",
        )
        for number, name, takes_s in ((1, "DASH", 10), (2, "PLOD", 11))
    )
    vocabulary = textwrap.dedent("""
        types: {robot: {}, job: {}, tag: {action_names: true}}
        functions: {}
        predicates:
          open: {arguments: {job: job}}
          done: {arguments: {job: job}}
          can: {arguments: {robot: robot, tag: tag}}
        actions:
        """)
    return read_knowledge_base(vocabulary.rstrip() + "\n" + ways, "test")


BASE = base()
ONE, TWO = (Fact("done", (job,)) for job in ("one", "two"))
SPREADS = {
    ("DASH", 1): Spread(relative=0.5, observations=KNOWN),
    ("PLOD", 1): Spread(relative=0.02, observations=KNOWN),
}


def problem(*goals: Fact, robots: tuple[str, ...] = ("r1", "r2"), **more: object) -> PlanningProblem:
    jobs = [goal.args[0] for goal in goals]
    known = PlanningProblem(
        objects=dict.fromkeys(robots, "robot") | dict.fromkeys(jobs, "job"),
        facts=frozenset(
            {Fact("open", (job,)) for job in jobs}
            | {Fact("can", (robot, tag)) for robot in robots for tag in ("DASH", "PLOD")}
        ),
        goals=goals,
        spreads=SPREADS,
    )
    return replace(known, **more)  # type: ignore[arg-type]


def planned(stated: PlanningProblem, objective: Objective, observer: Observer = UNOBSERVED) -> PlanNet:
    request = PlanningRequest(objective=objective, effort_s=0.2)
    result = engine_named("macta", BASE).plan(stated, request, observer)
    assert result.plan_net is not None, result.reason
    assert faults_of(result.plan_net, stated.facts, BASE) == []
    return result.plan_net


def chance(plan_net: PlanNet, stated: PlanningProblem) -> float:
    likely = forecast(plan_net, stated.deadlines_s, stated.spreads).on_time()
    assert likely is not None
    return likely


def test_the_shortest_plan_in_the_mean_is_not_the_most_likely_on_time() -> None:
    due = problem(ONE, deadlines_s={ONE: 12.0})
    shortest = planned(due, Objective.MAKESPAN)
    surest = planned(due, Objective.ON_TIME)
    assert [action.tag for action in shortest.actions] == ["DASH"]
    assert [action.tag for action in surest.actions] == ["PLOD"]
    assert surest.makespan_s == 11.0, "it is timed by what is expected"
    assert chance(shortest, due) < 0.85
    assert chance(surest, due) > 0.99


def test_a_deadline_that_only_luck_can_keep_is_left_to_luck() -> None:
    due = problem(ONE, deadlines_s={ONE: 8.0})
    assert [action.tag for action in planned(due, Objective.ON_TIME).actions] == ["DASH"]


@pytest.mark.parametrize("due", [{}, {ONE: 1000.0}])
def test_where_nothing_can_be_gained_the_plan_is_todays(due: dict[Fact, float]) -> None:
    stated = problem(ONE, TWO, deadlines_s=due)
    assert planned(stated, Objective.ON_TIME) == planned(stated, Objective.MAKESPAN)


def test_what_is_more_urgent_counts_more() -> None:
    """One robot, two jobs; only the first that it does can be in time."""
    for urgent, other in ((ONE, TWO), (TWO, ONE)):
        due = problem(
            ONE, TWO, robots=("r1",), deadlines_s={ONE: 12.0, TWO: 12.0}, priorities={urgent: 40, other: 0}
        )
        first = min(planned(due, Objective.ON_TIME).actions, key=lambda action: action.earliest_start_s)
        assert urgent in first.intended_effects


def test_progress_never_tells_of_makespans_or_bounds_of_varied_problems() -> None:
    class Heard(Observer):
        def __init__(self) -> None:
            self.told: list[Progress] = []

        def progress(self, progress: Progress) -> None:
            self.told.append(progress)

    heard = Heard()
    planned(problem(ONE, deadlines_s={ONE: 12.0}), Objective.ON_TIME, heard)
    assert {one.makespan_s for one in heard.told} - {None} == {10.0, 11.0}
    assert {one.lower_bound_s for one in heard.told} - {None} == {10.0}


def test_the_time_limit_is_for_all_plans_together() -> None:
    class Slow:
        """Takes 4 s of the stepped clock for each plan."""

        name = "slow"

        def __init__(self) -> None:
            self.now_s = 0.0
            self.asked = 0

        def clock(self) -> float:
            return self.now_s

        def plan(
            self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
        ) -> PlanningResult:
            self.now_s += 4.0
            self.asked += 1
            return engine_named("macta", BASE).plan(problem, PlanningRequest(effort_s=0.0))

    from planner.engines.on_time import OnTimeEngine

    slow = Slow()
    request = PlanningRequest(objective=Objective.ON_TIME, time_limit_s=10.0, clock=slow.clock)
    result = OnTimeEngine(slow, BASE).plan(problem(ONE, deadlines_s={ONE: 5.0}), request)
    assert result.plan_net is not None
    assert slow.asked == 2


def test_alternatives_name_the_plan_that_is_most_likely_on_time() -> None:
    due = problem(ONE, deadlines_s={ONE: 12.0})
    surest = engine_named("macta", BASE).plan(due, PlanningRequest(objective=Objective.ON_TIME, effort_s=0.0))
    found = alternatives(
        engine_named("macta", BASE), BASE, due, PlanningRequest(effort_s=0.0), k=4, proposed=surest
    )
    by_label = {one.label: one for one in found}
    assert by_label["most likely on time"].plan_net.makespan_s == 11.0
    assert "likelier on time" in by_label["most likely on time"].words
    assert by_label["most likely on time"].on_time > by_label["shortest time"].on_time


def test_without_deadlines_no_alternative_is_the_most_likely_on_time() -> None:
    found = alternatives(engine_named("macta", BASE), BASE, problem(ONE), PlanningRequest(effort_s=0.0), k=4)
    assert not any("on time" in one.label for one in found)
