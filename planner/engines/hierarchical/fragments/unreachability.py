"""A proof that goals are out of reach, from the world with everything alike taken for one.

Whatever can be done in the world can be done in its quotient, deletes left out, if two objects that are taken
for one may stand in for two. So what the quotient's delete relaxation does not reach, nothing reaches.
"""

from collections.abc import Hashable, Mapping, Sequence

from planner.engines.hierarchical.fragments.grounding import task_of
from planner.engines.hierarchical.fragments.heuristic import is_reachable
from planner.engines.hierarchical.fragments.relevance import goal_neighbourhood
from planner.engines.hierarchical.fragments.world_index import WorldIndex
from planner.fact import Fact
from planner.problem.interface import PlanningProblem

LARGEST = 20_000
"""The most steps of a quotient that is looked at."""


def is_out_of_reach(index: WorldIndex, goals: Sequence[Fact], deadline: float) -> bool:
    """True if it is proven that no sequence of actions reaches the goals."""
    stands_for = _representatives(index, goals)
    counts: dict[str, int] = {}
    for leader in stands_for.values():
        counts[leader] = counts.get(leader, 0) + 1
    quotient = WorldIndex(index.knowledge_base, _quotient(index.problem, stands_for))
    task = task_of(
        quotient,
        frozenset(counts),
        goals,
        limit=LARGEST,
        deadline=deadline,
        many=frozenset(leader for leader, count in counts.items() if count > 1),
    )
    return task is not None and not is_reachable(task)


def _representatives(index: WorldIndex, goals: Sequence[Fact]) -> Mapping[str, str]:
    """For each object the one that stands for it: agents by what they can do and which of the goals' objects
    they have to do with, others by which of these agents have to do with them and what is said of them; the
    goals' objects and those next to them stand for themselves."""
    own = {arg for goal in goals for arg in goal.args}
    own |= {name for name in goal_neighbourhood(index, goals, 2) if name not in index.agents}
    sorts = {kind: (profile, index.neighbours(kind) & own) for kind, profile in index.profiles.items()}
    leaders: dict[Hashable, str] = {}

    def key(name: str) -> Hashable:
        if name in own:
            return name
        if name in index.agents:
            return sorts[index.kind_of[name]]
        near = frozenset(sorts.get(node, node) for node in index.neighbours(name))  # type: ignore[arg-type]
        return index.objects[name], near, index.shape(name)

    return {name: leaders.setdefault(key(name), name) for name in sorted(index.objects)}


def _quotient(problem: PlanningProblem, stands_for: Mapping[str, str]) -> PlanningProblem:
    def led(args: tuple[str, ...]) -> tuple[str, ...]:
        return tuple([stands_for.get(arg, arg) for arg in args])

    return PlanningProblem(
        objects={leader: problem.objects[leader] for leader in stands_for.values()},
        facts=frozenset(Fact(fact.predicate, led(fact.args)) for fact in problem.facts),
        goals=problem.goals,
        functions={(name, led(args)): value for (name, args), value in problem.functions.items()},
    )
