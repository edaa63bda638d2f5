"""Long missions with batteries that do not last, in the simulation, beside plans that do not count on batteries.

`python -m benchmarks.batteries --runs 20`: in random stores with four robots, goals for many samples. The robots'
batteries are small, and begin at a random level. For each mission: the plan's makespan and how often robots charge on
the way; how the mission ended; the lowest battery, and the robots' lowest ones less those of the plan, both of their
parts: what a robot does afterwards, such as to drive home to charge, is no part of the plan. The lowest battery with
that is told beside.
"""

import argparse
import random
from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import median

from app.cli.simulated_mission import MissionResult, simulate_mission
from app.cli.trials.offline_mission import NoMission, goal_problem, plan_mission
from app.cli.trials.random_goals import drawn_goals
from app.domain.world_model import initial_facts
from planner import PlanningRequest, load_knowledge_base
from planner.engines.registry import portfolio
from planner.problem.number_courses import courses
from robots.world import WorldFile, generate_world, store_shape
from sim import Truth

LEVELS = (0.25, 0.5)
"""At which batteries begin."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """A mission as planned and as carried out.

    :param least: the lowest battery of a robot of the plan while it does its part, a share.
    :param later: the lowest until the mission has ended.
    :param errors: of each robot its lowest battery while it does its part, less the one by the plan.
    """

    makespan_s: float
    planning_s: float
    charges: int
    result: MissionResult
    least: float
    later: float
    errors: Sequence[float]

    def __str__(self) -> str:
        ended = self.result.outcome.value
        if not self.result.came_true:
            ended = f"{self.result.packet}: {self.result.reason}"
        worst = max(self.errors, key=abs, default=0.0)
        return (
            f"planned {self.makespan_s:6.1f} s in {self.planning_s:.2f} s, {self.charges} charges, took "
            f"{self.result.truth.time_s:6.1f} s, lowest {self.least:.0%}, off by {worst:+.1%}, "
            f"{self.later:.0%} in the end, {ended}"
        )


def store(seed: int, *, goals: int, battery_wh: float, shared: bool) -> WorldFile:
    """A store whose robots have small batteries that begin at random levels.

    :param shared: the robots of an area share a charger: three in the yard.
    """
    chance = random.Random(seed)
    shape = store_shape(
        samples=goals, aisles=2, store_robots=2, yard_robots=2 + shared, doors=4, bays=6 * goals
    )
    world = generate_world(shape, seed=seed, shared_chargers=shared)
    robots = tuple(
        robot.model_copy(update={"battery": round(chance.uniform(*LEVELS), 3), "battery_wh": battery_wh})
        for robot in world.robots
    )
    return world.model_copy(update={"robots": robots})


def carried_out(world: WorldFile, *, goals: int, seed: int, counts: bool) -> Run:
    """:param counts: whether the plan counts on batteries."""
    base = load_knowledge_base()
    facts = initial_facts(world, base)
    problem = goal_problem(world, facts, drawn_goals(world, facts, goals, seed, base), base)
    planned = problem if counts else replace(problem, numbers={})
    engine = portfolio(base)
    request = PlanningRequest()
    timer = request.timer()
    mission = plan_mission(world, planned, engine, base, request)
    planning_s = timer.elapsed_s
    levels: dict[str, list[tuple[float, float]]] = {robot: [] for robot in mission.plan_net.robots}

    def watch(truth: Truth) -> None:
        for robot, course in levels.items():
            course.append((truth.time_s, truth.batteries[robot]))

    result = simulate_mission(mission, seed=seed, watch=watch)
    robots = {script.id: script.robot for script in mission.scripts}
    ended_s = {robots[report.script_id]: report.at_s for report in result.reports}
    least = {
        robot: min(level for at_s, level in course if at_s <= ended_s.get(robot, at_s))
        for robot, course in levels.items()
    }
    lowest = {
        course.term[1][0]: min(point.value for point in course.points)
        for course in courses(mission.plan_net, problem, base)
    }
    return Run(
        makespan_s=mission.plan_net.makespan_s,
        planning_s=planning_s,
        charges=sum(action.level is not None for action in mission.plan_net.actions),
        result=result,
        least=min(least.values()),
        later=min(level for course in levels.values() for _, level in course),
        errors=[least[robot] - level for robot, level in lowest.items()],
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--goals", type=int, default=8)
    parser.add_argument("--battery-wh", type=float, default=3.0)
    parser.add_argument("--shared", action="store_true", help="robots share chargers")
    arguments = parser.parse_args()
    seeds = range(arguments.seed, arguments.seed + arguments.runs)
    for counts in (True, False):
        print("plans that count on batteries" if counts else "plans that do not")
        runs: list[Run] = []
        for seed in seeds:
            world = store(
                seed, goals=arguments.goals, battery_wh=arguments.battery_wh, shared=arguments.shared
            )
            try:
                run = carried_out(world, goals=arguments.goals, seed=seed, counts=counts)
            except NoMission as error:
                print(f"{seed:4} no plan: {error}")
                continue
            runs.append(run)
            print(f"{seed:4} {run}", flush=True)
        true = sum(run.result.came_true for run in runs)
        errors = sorted(error for run in runs for error in run.errors)
        print(
            f"came true {true} of {len(seeds)}; lowest battery {min(run.least for run in runs):.0%}, "
            f"{min(run.later for run in runs):.0%} in the end; a robot's lowest differs from the plan's by "
            f"{median(errors):+.1%} in the median, {errors[0]:+.1%} to {errors[-1]:+.1%}"
        )


if __name__ == "__main__":
    main()
