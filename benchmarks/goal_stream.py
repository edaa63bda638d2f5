"""A stream of goals, planned in five ways: `python -m benchmarks.goal_stream [--goals 200] [--robots 16]`.

Goals to move a sample each arrive at random times in a random store; what is planned is carried out exactly as
scheduled.

- alone: each goal has a plan and a mission of its own as soon as robots, places and samples that the missions under way
  do not need any longer suffice for one; until then it waits.
- four: likewise, but up to four that wait and are within reach have one plan and one mission, as in the service.
- joined: each goal is planned around one plan for all, whose actions are neither changed nor delayed (`join`).
- rolling: joined; then all that has not begun is planned again, and that plan is taken if its goals are achieved sooner
  on average.
- at once: all goals are known at the start and planned together, for comparison.

Printed: goals achieved while they arrive, minutes from a goal's statement to when it is true (mean, 95th percentile,
longest; at once: from the start), when the last is true, and CPU seconds of planning for each goal.
"""

import argparse
import random
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf
from statistics import mean

from app.domain.world_model import initial_facts, initial_spots, planning_problem
from app.domain.world_model.reservation import is_withheld, needed_by, union_of
from benchmarks.planner.scheduled_progress import as_scheduled
from planner import (
    GOAL,
    Fact,
    KnowledgeBase,
    PlanNet,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    load_knowledge_base,
)
from planner.engines.hierarchical.hierarchical_engine import HierarchicalEngine
from planner.relaxation import unreachable_goals
from planner.repair import Repair, join, repair
from robots.world import Sample, WorldFile, generate_world, store_shape

REQUEST = PlanningRequest(time_limit_s=30.0)
Arrivals = Mapping[Fact, float]
"""When each goal is stated, seconds."""


@dataclass(kw_only=True)
class Outcome:
    """`achieved_s`: by goal when it is true; `cpu_s`: of the planning after each arrival or end of an action."""

    achieved_s: dict[Fact, float] = field(default_factory=dict)
    cpu_s: list[float] = field(default_factory=list)

    def timed(self, work: Callable[[], PlanNet | None]) -> PlanNet | None:
        began = time.process_time()
        found = work()
        self.cpu_s.append(time.process_time() - began)
        return found


def stream(goals: int, robots: int, seconds: float, seed: int) -> tuple[WorldFile, dict[Fact, float]]:
    """A store whose samples go from doors to bays or from bays to doors, half of them each, and when that is asked."""
    chance = random.Random(f"stream/{goals}/{robots}/{seed}")
    half = robots // 2
    shape = store_shape(
        samples=0,
        aisles=half,
        store_robots=half,
        yard_robots=half,
        doors=goals,
        bays=max(6 * half, goals),
        interchanges=2 * half,
    )
    world = generate_world(shape)
    doors = chance.sample([one.name for one in world.locations if one.kind == "door"], goals)
    bays = chance.sample([one.name for one in world.locations if one.kind == "bay"], goals)
    ways = [(a, b) if n % 2 else (b, a) for n, (a, b) in enumerate(zip(doors, bays, strict=True))]
    samples = [
        Sample(name=f"sample_{n}", at=start).model_dump() for n, (start, _) in enumerate(ways, start=1)
    ]
    times = sorted(chance.uniform(0.0, seconds) for _ in ways)
    stated = {
        Fact("object_position", (f"sample_{n}", "in", end)): at
        for n, ((_, end), at) in enumerate(zip(ways, times, strict=True), start=1)
    }
    return WorldFile.model_validate({**world.model_dump(), "samples": samples}), stated


def achieved_in(plan_net: PlanNet, began_s: float) -> dict[Fact, float]:
    """When a plan-net that begins then achieves its goals."""
    ends_s = {action.id: action.earliest_end_s for action in plan_net.actions}
    return {
        link.fact: began_s + ends_s.get(link.producer, 0.0)
        for link in plan_net.causal_links
        if link.consumer == GOAL
    }


def when_free(
    engine: PlanningEngine, base: KnowledgeBase, problem: PlanningProblem, stated: Arrivals, *, at_most: int
) -> Outcome:
    """:param at_most: so many goals that wait have one plan and one mission."""
    outcome = Outcome()
    missions: list[tuple[float, PlanNet]] = []
    waiting: list[Fact] = []
    arrivals = sorted(stated, key=stated.__getitem__)
    events = sorted(set(stated.values()))

    def planned(now_s: float) -> PlanNet | None:
        left = [
            action
            for began_s, net in missions
            for action in net.actions
            if began_s + action.earliest_end_s > now_s
        ]
        reserved = union_of(needed_by(action) for action in left)
        facts = _facts(problem, missions, now_s)
        free = frozenset(fact for fact in facts if not is_withheld(fact, reserved))
        out_of_reach = {*unreachable_goals(base, replace(problem, facts=free, goals=tuple(waiting)))}
        within = [goal for goal in waiting if goal not in out_of_reach][:at_most]
        while within:
            net = engine.plan(replace(problem, facts=free, goals=tuple(within)), REQUEST).plan_net
            if net is not None:
                return net
            within = within[: len(within) // 2]
        return None

    while events:
        now_s = events.pop(0)
        while arrivals and stated[arrivals[0]] <= now_s:
            waiting.append(arrivals.pop(0))
        while waiting and (net := outcome.timed(partial(planned, now_s))) is not None:
            waiting = [goal for goal in waiting if goal not in net.goals]
            missions.append((now_s, net))
            outcome.achieved_s |= achieved_in(net, now_s)
            ends = {round(now_s + net.of_robot(robot)[-1].earliest_end_s, 3) for robot in net.robots}
            events = sorted({*events, *ends})
    return outcome


def _facts(
    problem: PlanningProblem, missions: Sequence[tuple[float, PlanNet]], now_s: float
) -> frozenset[Fact]:
    """The facts once the missions have come so far."""
    state = set(problem.facts)
    changes = [
        (began_s + (action.earliest_end_s if ends else action.earliest_start_s), not ends, action)
        for began_s, net in missions
        for action in net.actions
        for ends in (True, False)
    ]
    for at_s, begins, action in sorted(changes, key=lambda one: one[:2]):
        if begins and at_s < now_s:
            state.difference_update(action.deletes)
        elif not begins and at_s <= now_s:
            state.update(action.effects)
    return frozenset(state)


@dataclass(kw_only=True)
class OnePlan:
    """One plan for all goals, from `began_s` on, and the facts that it begins with.

    :param improves: all that has not begun is planned again with each new goal.
    """

    engine: PlanningEngine
    base: KnowledgeBase
    problem: PlanningProblem
    improves: bool
    plan: PlanNet
    began_s: float = 0.0

    def with_goals(self, new: Sequence[Fact], open_goals: Sequence[Fact], now_s: float) -> PlanNet | None:
        """The plan from now on with these goals, too, which becomes this one; None if there is none."""
        elapsed_s = now_s - self.began_s
        present, progress = as_scheduled(self.plan, self.problem.facts, elapsed_s)
        plan = replace(self.plan, goals=tuple(open_goals))
        wanted = replace(self.problem, facts=present, goals=(*open_goals, *new))
        found = [join(self.engine, self.base, plan, wanted, progress, new, REQUEST)]
        if self.improves or found[0].plan_net is None:
            begun = {*progress.done, *progress.under_way}
            bare = replace(plan, actions=tuple(one for one in plan.actions if one.id in begun))
            found.append(repair(self.engine, self.base, bare, wanted, progress, REQUEST))
        best = min(found, key=_mean_s)
        if best.plan_net is None:
            return None
        self.plan, self.problem, self.began_s = best.plan_net, best.problem, now_s
        return best.plan_net


def _mean_s(found: Repair) -> float:
    """When its goals are achieved, on average; infinite without a plan."""
    return inf if found.plan_net is None else mean(achieved_in(found.plan_net, 0.0).values())


def together(
    engine: PlanningEngine,
    base: KnowledgeBase,
    problem: PlanningProblem,
    stated: Arrivals,
    *,
    improves: bool,
) -> Outcome:
    outcome = Outcome()
    nothing = engine.plan(problem, REQUEST).plan_net
    assert nothing is not None
    running = OnePlan(engine=engine, base=base, problem=problem, improves=improves, plan=nothing)
    waiting: list[Fact] = []
    for goal, now_s in sorted(stated.items(), key=lambda one: one[1]):
        waiting.append(goal)
        still = [one for one, at_s in outcome.achieved_s.items() if at_s > now_s]
        net = outcome.timed(partial(running.with_goals, tuple(waiting), still, now_s))
        if net is not None:  # else they wait for the next goal
            waiting.clear()
            outcome.achieved_s |= achieved_in(net, now_s)
    return outcome


def at_once(engine: PlanningEngine, problem: PlanningProblem, stated: Arrivals) -> Outcome:
    outcome = Outcome()
    net = outcome.timed(lambda: engine.plan(replace(problem, goals=tuple(stated)), REQUEST).plan_net)
    if net is not None:
        outcome.achieved_s = achieved_in(net, 0.0)
    return outcome


def row(name: str, outcome: Outcome, stated: Arrivals, seconds: float) -> str:
    waits = sorted(
        at_s - (0.0 if name == "at once" else stated[goal]) for goal, at_s in outcome.achieved_s.items()
    )
    in_time = sum(at_s <= seconds for at_s in outcome.achieved_s.values())
    cpu = sum(outcome.cpu_s) / len(stated)
    if not waits:
        return f"| {name} | no plan | | | | {cpu:.2f} |"
    return (
        f"| {name} | {in_time} of {len(stated)} | {mean(waits) / 60:.1f}, {waits[int(0.95 * len(waits))] / 60:.1f}, "
        f"{waits[-1] / 60:.1f} | {max(outcome.achieved_s.values()) / 60:.1f} "
        f"| {len(stated) - len(outcome.achieved_s)} | {cpu:.2f} |"
    )


def rows(goals: int, robots: int, seconds: float, seed: int, ways: Sequence[str]) -> Iterator[str]:
    base = load_knowledge_base()
    engine = HierarchicalEngine(base)
    engine.warm_up()
    world, stated = stream(goals, robots, seconds, seed)
    problem = planning_problem(world, initial_facts(world, base), (), spots=initial_spots(world))
    measured: Mapping[str, Callable[[], Outcome]] = {
        "alone": lambda: when_free(engine, base, problem, stated, at_most=1),
        "four": lambda: when_free(engine, base, problem, stated, at_most=4),
        "joined": lambda: together(engine, base, problem, stated, improves=False),
        "rolling": lambda: together(engine, base, problem, stated, improves=True),
        "at once": lambda: at_once(engine, problem, stated),
    }
    for name in ways:
        yield row(name, measured[name](), stated, seconds)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    options.add_argument("--goals", type=int, default=200)
    options.add_argument("--robots", type=int, default=16)
    options.add_argument("--seconds", type=float, default=3600.0, help="the time over which goals arrive")
    options.add_argument("--seeds", type=int, nargs="+", default=[1])
    options.add_argument("--ways", nargs="+", default=["alone", "four", "joined", "rolling", "at once"])
    given = options.parse_args()
    for seed in given.seeds:
        print(f"\n{given.goals} goals, {given.robots} robots, {given.seconds:g} s, seed {seed}\n")
        print(
            "| planned | achieved in that time | minutes to it: mean, p95, longest | last, min | never | CPU s a goal |"
        )
        print("|---|---|---|---|---|---|", flush=True)
        for line in rows(given.goals, given.robots, given.seconds, seed, given.ways):
            print(line, flush=True)


if __name__ == "__main__":
    main()
