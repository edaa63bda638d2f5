"""What makes one plan better than another."""

from types import SimpleNamespace
from typing import cast

import pytest

from planner import Objective, PlanNet
from planner.engines.plan_net_completion import merit

NET = cast(
    PlanNet,
    SimpleNamespace(
        actions=[SimpleNamespace(duration_s=12.0), SimpleNamespace(duration_s=30.0)],
        makespan_s=40.0,
        clearances=1,
        robots=("yard_1", "store_2"),
        energy_j=70.0,
    ),
)
USUAL = (40.0, 1, 42.0)


@pytest.mark.parametrize(
    ("objective", "quantities"),
    [
        (Objective.MAKESPAN, USUAL),
        (Objective.ROBOTS, (2, *USUAL)),
        (Objective.ENERGY, (70.0, *USUAL)),
    ],
)
def test_the_objective_counts_before_makespan_clearances_and_work(
    objective: Objective, quantities: tuple[float, ...]
) -> None:
    assert merit(NET, objective) == quantities
