"""A plan-net in the terminal."""

from dataclasses import replace

from rich.console import Console

from app.cli.show import show_plan
from app.plan_body import PlanBody
from tests.app.store import Store

STORE = Store()


def shown(plan: PlanBody) -> str:
    console = Console(width=100)
    with console.capture() as capture:
        show_plan(console, plan)
    return " ".join(capture.get().split())


def test_the_critical_path_and_what_the_plan_takes_are_told() -> None:
    net = replace(STORE.store_sample_1(), recruitment={"yard_1": "can NAVIGATE"})
    plan = PlanBody.of_plan_net(net, STORE.base, engine="by hand")
    text = shown(plan)
    assert f"Critical path: {' → '.join(net.critical_path)}" in text
    assert f"{net.makespan_s:.0f} s, {net.distance_m:.0f} m, {net.energy_j:.0f} J" in text
    drives = sum(action.distance_m for action in net.of_robot("yard_1"))
    assert f"yard_1 ({drives:.0f} m, " in text


def test_a_long_critical_path_is_shortened_in_the_middle() -> None:
    plan = PlanBody.of_plan_net(STORE.store_sample_1(), STORE.base)
    text = shown(plan.model_copy(update={"critical_path": tuple(f"a{n}" for n in range(1, 31))}))
    assert "a5 → a6 → (18 more) → a25 → a26" in text


def test_a_goal_after_its_deadline_is_told() -> None:
    net = STORE.store_sample_1()
    late = PlanBody.of_plan_net(replace(net, late={net.goals[0]: 12.0}), STORE.base)
    assert "in(sample_1, bay_7) comes 12 s after its deadline" in shown(late)
