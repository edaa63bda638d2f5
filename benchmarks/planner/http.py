"""A client's waiting time at paper size: from posting goals to the proposed plan, over HTTP on loopback."""

from collections.abc import Mapping
from statistics import median

from benchmarks.latency import goal_to_plan_s, served

GOALS = (
    "move sample_1 to bay_7",
    "move sample_2 to bay_3",
    "move sample_3 to bay_12",
    "move sample_4 to bay_6",
)


def proposals(*, runs: int) -> Mapping[int, float]:
    """Median seconds by number of goals in one request, 1 to 4; the first run of each is not counted."""
    medians = {}
    with served() as api:
        for count in range(1, len(GOALS) + 1):
            took = []
            for _ in range(runs + 1):
                seconds, plan_id = goal_to_plan_s(api, " and ".join(GOALS[:count]))
                took.append(seconds)
                api.post(f"/v1/plans/{plan_id}:reject", json={"comment": "measured"})
            medians[count] = median(took[1:])
    return medians
