"""Random goals from sentence to the simulated world's truth: how many come true, and how good the estimate is.

uv run python -m benchmarks.goals [SETS] [GOALS A SET]
"""

import random
import statistics
import sys
from collections.abc import Sequence
from dataclasses import dataclass

from app.goals.berths import berthed
from app.goals.grammar import parse_goal
from app.organiser import Organised, load_library, organise
from app.vocabulary import planner_fact, symbolic_all
from app.world_model import initial_facts, initial_spots, objects_of, planning_problem
from benchmarks.errands import Crew
from planner import KnowledgeBase, PlanNet, PlanningRequest, load_knowledge_base
from planner.fast_downward import FastDownwardEngine
from robots.wire import BehaviourScript, ScriptReport, SymbolicFact
from robots.world import WorldFile, load_world
from sim import Truth

TIMEOUT_S = 900.0


class NoMission(Exception):
    """Raised when a sentence is not understood, planned or organised; says which and why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mission:
    """A sentence turned into scripts."""

    world: WorldFile
    goals: Sequence[SymbolicFact]
    plan_net: PlanNet
    scripts: Sequence[BehaviourScript]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How a mission ended, in the simulated world itself and in the robots' own words."""

    truth: Truth
    reports: Sequence[ScriptReport]
    came_true: bool

    @property
    def words(self) -> list[str]:
        return [f"{report.script_id}: {report.state} {report.detail}" for report in self.reports]


def prepare(world: WorldFile, sentence: str, base: KnowledgeBase, *, time_limit_s: float = 60.0) -> Mission:
    """Understand, plan and organise a sentence from the world's initial facts.

    :raises NoMission: if one of the three fails.
    """
    facts = initial_facts(world, base)
    goals = parse_goal(sentence, world, facts)
    if not isinstance(goals, tuple):
        raise NoMission(goals.detail)
    objects = objects_of(world)
    wanted = [planner_fact(goal, base, objects) for goal in berthed(goals, world, facts)]
    problem = planning_problem(world, facts, wanted, spots=initial_spots(world))
    result = FastDownwardEngine(base).plan(problem, PlanningRequest(time_limit_s=time_limit_s))
    if result.plan_net is None:
        raise NoMission(f"{result.status}: {result.reason}")
    return written(world, result.plan_net, base)


def written(world: WorldFile, plan_net: PlanNet, base: KnowledgeBase) -> Mission:
    """Organise a plan-net.

    :raises NoMission: if that fails.
    """
    repertoires = {robot.name: robot.repertoire for robot in world.robots}
    organised = organise(plan_net, load_library(base), repertoires, "mission", base)
    if not isinstance(organised, Organised):
        raise NoMission(organised.reason)
    goals = symbolic_all(plan_net.goals, base)
    return Mission(world=world, goals=goals, plan_net=plan_net, scripts=organised.scripts)


def carry_out(mission: Mission, *, seed: int) -> Ended:
    """Have the simulated robots do it, flat out."""
    crew = Crew(mission.world, seed=seed)
    crew.run(list(mission.scripts), timeout_s=TIMEOUT_S)
    truth = crew.simulation.truth()
    crew.simulation.close()
    came_true = all(truth.samples[goal.args[0]].ref == goal.args[1] for goal in mission.goals)
    return Ended(truth=truth, reports=list(crew.ended.values()), came_true=came_true)


def random_sentence(world: WorldFile, goals: int, chance: random.Random) -> str:
    """So many different samples, each to a different place that is free at the start."""
    taken = {sample.at for sample in world.samples}
    free = [p.name for p in world.locations if p.kind in ("bay", "door") and p.name not in taken]
    samples = chance.sample([sample.name for sample in world.samples], goals)
    return " and ".join(f"move {s} to {p}" for s, p in zip(samples, chance.sample(free, goals), strict=True))


def main(sets: int = 20, goals: int = 2) -> None:
    base, world = load_knowledge_base(), load_world("sample_store")
    unplanned, untrue, ratios = [], [], []
    for seed in range(sets):
        sentence = random_sentence(world, goals, random.Random(seed))
        try:
            mission = prepare(world, sentence, base)
        except NoMission as error:
            unplanned.append(f"{sentence}: {error}")
            continue
        ended = carry_out(mission, seed=seed)
        if not ended.came_true:
            untrue.append(f"{sentence} (seed {seed}): {ended.words}")
        ratios.append(ended.truth.time_s / mission.plan_net.makespan_s)
    tried = sets - len(unplanned)
    print(f"{sets} sets of {goals} goals: planned {tried}, came true {tried - len(untrue)} of {tried}")
    if ratios:
        print(
            f"took / estimated: median {statistics.median(ratios):.2f}, {min(ratios):.2f} to {max(ratios):.2f}"
        )
    for line in (*unplanned, *untrue):
        print("  ", line)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
