"""The course of numbers under a plan-net, by its times."""

from dataclasses import replace

import pytest

from app.domain.world_model import planning_problem
from planner import PlanNet, PlanningProblem, load_knowledge_base
from planner.plan_nets.plan_net import PlanNetAction
from planner.problem.number_courses import courses, why_outside
from tests.app.sample_store import Store

BASE = load_knowledge_base()
STORE = Store()
NET = STORE.store_sample_1()
CAPACITY_J = 120 * 3600
IDLE_W = 5.0
LOADED_W = 9.0
"""While it waits for a TRANSPORT: it looks whether it has to withdraw first."""


def problem(**levels: float) -> PlanningProblem:
    stated = planning_problem(STORE.world, STORE.facts, NET.goals, knowledge_base=BASE)
    return replace(stated, numbers={("battery", (robot,)): level for robot, level in levels.items()})


def energy_j(net: PlanNet, robot: str) -> float:
    """Until the robot's part is done."""
    mine = net.of_robot(robot)
    waiting_s = mine[-1].earliest_end_s - sum(one.duration_s for one in mine)
    return sum(one.energy_j for one in mine) + IDLE_W * waiting_s


def test_a_battery_falls_by_what_its_robot_does_and_by_waiting() -> None:
    (course,) = courses(NET, problem(store_2=0.5), BASE)
    assert course.term == ("battery", ("store_2",))
    assert course.start == 0.5
    assert course.end == pytest.approx(0.5 - energy_j(NET, "store_2") / CAPACITY_J)
    assert [one.value for one in course.points] == sorted((one.value for one in course.points), reverse=True)
    assert list(course.outside()) == []


def delayed(first: PlanNetAction, seconds: float) -> PlanNet:
    """The plan-net as if its robot waited so long for the action."""
    later = {
        one.id for one in NET.of_robot(first.agents[0]) if one.earliest_start_s >= first.earliest_start_s
    }
    actions = [
        replace(one, earliest_start_s=one.earliest_start_s + seconds * (one.id in later))
        for one in NET.actions
    ]
    return replace(NET, actions=tuple(actions))


@pytest.mark.parametrize(
    ("tag", "watts"), [("NAVIGATE", IDLE_W), ("DOCK", IDLE_W), ("TRANSPORT", LOADED_W), ("RELEASE2", IDLE_W)]
)
def test_waiting_drains_a_battery_by_what_the_robot_waits_for(tag: str, watts: float) -> None:
    (awaited,) = [one for one in NET.of_robot("yard_1") if one.tag == tag]
    (soon,) = courses(NET, problem(yard_1=0.5), BASE)
    (late,) = courses(delayed(awaited, 300.0), problem(yard_1=0.5), BASE)
    assert (soon.end - late.end) * CAPACITY_J == pytest.approx(300.0 * watts)


def test_only_the_first_phase_of_an_action_is_waited_for_as_the_whole_is() -> None:
    whole = next(one for one in NET.actions if one.tag == "TRANSPORT").unscheduled()
    term = ("battery", whole.agents)
    phases = [phase for number in (1, 2, 3) if (phase := BASE.phase_of(whole, number)) is not None]
    capacity = {("capacity_j", whole.agents): 1.0}
    assert [BASE.drain_of(term, capacity, one) for one in (whole, *phases)] == [
        *(LOADED_W, LOADED_W),
        *(IDLE_W, IDLE_W),
    ]


def test_robots_that_do_nothing_and_unknown_batteries_have_no_course() -> None:
    assert courses(NET, problem(), BASE) == ()
    assert courses(NET, problem(store_1=0.01), BASE) == ()
    assert len(courses(NET, problem(store_2=0.5, yard_1=0.5), BASE)) == 2


def test_where_a_battery_falls_below_what_is_kept_is_said() -> None:
    level = 0.2 + 0.5 * energy_j(NET, "yard_1") / CAPACITY_J
    (course,) = courses(NET, problem(yard_1=level), BASE)
    first = next(course.outside())
    assert first.at_s < NET.makespan_s
    words = why_outside(course, first, NET.actions, BASE)
    assert words.startswith("yard_1's battery is at 19.9 % at ")
    assert words.endswith("and plans keep it at 20 % or more")
    (course,) = courses(NET, problem(yard_1=0.1), BASE)
    assert next(one.action for one in course.outside()) == NET.actions.index(NET.of_robot("yard_1")[0])


def charged_at(index: int) -> PlanNet:
    """The plan-net as if yard_1's action of this number were a charge."""
    charge = BASE.ground(
        "CHARGE",
        {"robot": "yard_1", "rel": "near", "ref": "home_yard_1"},
        problem().functions,
        objects=problem().objects,
    )
    one = NET.of_robot("yard_1")[index]
    made = replace(
        one,
        level=0.2,
        **{
            name: getattr(charge, name)
            for name in ("tag", "arguments", "preconditions", "intended_effects", "duration_s", "energy_j")
        },
    )
    return replace(NET, actions=tuple(made if action is one else action for action in NET.actions))


def test_one_that_is_low_from_the_start_is_excused_on_its_way_to_the_charger_alone() -> None:
    (course,) = courses(charged_at(1), problem(yard_1=0.19), BASE)
    first = NET.actions.index(NET.of_robot("yard_1")[0])
    assert all(one.action > first for one in course.outside())
    (course,) = courses(charged_at(2), problem(yard_1=0.19), BASE)
    assert next(course.outside()).action == first, "it has gripped something before"
    (course,) = courses(charged_at(1), problem(yard_1=1e-6), BASE)
    assert next(course.outside()).action == first, "it does not last for the way"
