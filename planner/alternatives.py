"""Alternative plans to choose from: each is the best found by some criterion.

Found by solving the same problem with other objectives, and without robots of the shortest plan.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from planner.explanation.recruiting import recruitment_of, robots_by_work
from planner.knowledge import KnowledgeBase
from planner.knowledge.phrases import enumeration
from planner.plan_nets.completion import forecast
from planner.plan_nets.forecast import Forecast
from planner.plan_nets.plan_net import PlanNet
from planner.problem.interface import (
    UNOBSERVED,
    Objective,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
)
from planner.problem.preference import Preference, judged
from planner.problem.solving import TimeLimitedEngine
from planner.problem.static_facts import StaticFacts

SHORTEST = "shortest time"
CRITERIA = (Objective.MAKESPAN, Objective.ROBOTS, Objective.ENERGY)
"""What is planned for; which plan is the most likely on time is looked for among those."""
LIKELIER = 0.01
"""Chances to be on time that differ by less count as equal."""

Activities = tuple[tuple[str, tuple[str, ...], tuple[tuple[str, str], ...]], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Alternative:
    """A plan, the criteria by which it is best, and what it costs and saves against the shortest, in words."""

    label: str
    words: str
    result: PlanningResult
    plan_net: PlanNet
    forecast: Forecast

    @property
    def on_time(self) -> float:
        """The probability that all goals keep their deadlines; 1 if none has one."""
        chance = self.forecast.on_time()
        return 1.0 if chance is None else chance


def alternatives(
    engine: PlanningEngine,
    knowledge_base: KnowledgeBase,
    problem: PlanningProblem,
    request: PlanningRequest,
    observer: Observer = UNOBSERVED,
    *,
    k: int,
    proposed: PlanningResult | None = None,
) -> tuple[Alternative, ...]:
    """At most k plans of which no two do the same, the shortest first; none if the problem has no plan.

    The request's time limit is for all of them together; its objective does not matter.

    :param proposed: a plan that is known already, one more to choose from.
    """
    statics = StaticFacts(knowledge_base, problem)
    pool = _Pool(engine, statics, problem, request, observer)
    if proposed is not None:
        pool.add(proposed)
    for objective in CRITERIA:
        pool.solve(problem, objective)
    if not pool.plans:
        return ()
    _spare_robots(pool, statics, most=k)
    shortest = pool.best(_time)
    labels: dict[Activities, list[str]] = {}
    for label, plan_net in _claims(pool, shortest):
        labels.setdefault(activities(plan_net), []).append(label)
    quickest = pool.plans[activities(shortest)]
    return tuple(
        replace(pool.plans[key], label=", ".join(names), words=_compared(pool.plans[key], quickest))
        for key, names in list(labels.items())[:k]
    )


def with_choices_of(
    proposed: PlanningResult, result: PlanningResult, preferences: Sequence[Preference]
) -> PlanningResult:
    """An alternative with what the proposed plan tells of optional goals and preferences.

    The goals are those of the proposed plan, so all leave out the same; an alternative may keep more preferences.
    """
    result = replace(
        result, value=proposed.value, value_bound=proposed.value_bound, left_out=proposed.left_out
    )
    if proposed.preferences is None or result.plan_net is None:
        return result
    outcomes = proposed.preferences.outcomes
    told = {one.words: one for one in outcomes}
    judgements = (
        told.get(one.words, one) if not one.is_kept else one
        for one in judged(preferences, result.plan_net, otherwise="the world has changed since")
    )
    return replace(result, preferences=replace(proposed.preferences, outcomes=tuple(judgements)))


def activities(plan_net: PlanNet) -> Activities:
    """What is done by whom, regardless of time: equal for plans that do the same."""
    return tuple(sorted((a.tag, a.agents, tuple(sorted(a.arguments.items()))) for a in plan_net.actions))


Merit = tuple[float, ...]


def _time(plan_net: PlanNet) -> Merit:
    return plan_net.makespan_s, len(plan_net.robots), plan_net.energy_j, plan_net.clearances


def _team(plan_net: PlanNet) -> Merit:
    return len(plan_net.robots), *_time(plan_net)


def _energy(plan_net: PlanNet) -> Merit:
    return plan_net.energy_j, *_time(plan_net)


def _contact(plan_net: PlanNet) -> Merit:
    return plan_net.clearances, *_time(plan_net)


class _Pool:
    """The plans found so far, no two of which do the same."""

    def __init__(
        self,
        engine: PlanningEngine,
        statics: StaticFacts,
        problem: PlanningProblem,
        request: PlanningRequest,
        observer: Observer,
    ) -> None:
        """:param statics: of the problem as it is, in which every robot may be recruited."""
        self._statics = statics
        self._problem = problem
        self._solving = TimeLimitedEngine(engine, request, observer)
        self.plans: dict[Activities, Alternative] = {}

    def add(self, result: PlanningResult) -> None:
        """Of plans that do the same the shorter is kept, of equal ones the first."""
        if (plan_net := result.plan_net) is None:
            return
        known = self.plans.get(activities(plan_net))
        if known is None or plan_net.makespan_s < known.plan_net.makespan_s:
            likely = forecast(plan_net, self._problem.deadlines_s, self._problem.spreads)
            self.plans[activities(plan_net)] = Alternative(
                label="", words="", result=result, plan_net=plan_net, forecast=likely
            )

    def solve(self, problem: PlanningProblem, objective: Objective) -> None:
        result = self._solving.plan_if_time(problem, objective)
        if result is not None and (plan_net := result.plan_net) is not None:
            recruitment = recruitment_of(plan_net.actions, self._statics)
            self.add(replace(result, plan_net=replace(plan_net, recruitment=recruitment)))

    def plan_nets(self) -> list[PlanNet]:
        return [plan.plan_net for plan in self.plans.values()]

    def best(self, merit: Callable[[PlanNet], Merit]) -> PlanNet:
        return min(self.plan_nets(), key=merit)


def _spare_robots(pool: _Pool, statics: StaticFacts, *, most: int) -> None:
    """Solve without each robot of the shortest plan. A plan found so may become the shortest itself."""
    spared: list[str] = []
    while len(spared) < most:
        robots = (robot for robot in robots_by_work(pool.best(_time)) if robot not in spared)
        if (robot := next(robots, None)) is None:
            return
        pool.solve(statics.without({robot}), Objective.MAKESPAN)
        spared.append(robot)


def _claims(pool: _Pool, shortest: PlanNet) -> Iterator[tuple[str, PlanNet]]:
    """Each criterion in which the plans differ, with the plan that is best by it."""
    plan_nets = pool.plan_nets()
    yield SHORTEST, shortest
    surest = max(pool.plans.values(), key=lambda plan: plan.on_time)
    if surest.on_time > pool.plans[activities(shortest)].on_time + LIKELIER:
        yield "most likely on time", surest.plan_net
    if _differ(len(net.robots) for net in plan_nets):
        yield "fewest robots", pool.best(_team)
    if _differ(net.energy_j for net in plan_nets):
        yield "least energy", pool.best(_energy)
    if _differ(net.clearances for net in plan_nets):
        calmest = pool.best(_contact)
        yield "fewest clearances" if calmest.clearances else "needs no contact", calmest
    others = []
    for robot in robots_by_work(shortest):
        without = [net for net in plan_nets if robot not in net.robots]
        if without:
            others.append((f"without {robot}", min(without, key=_time)))
    yield from sorted(others, key=lambda other: _time(other[1]))


def _differ(figures: Iterable[float]) -> bool:
    return len(set(figures)) > 1


def _compared(plan: Alternative, quickest: Alternative) -> str:
    """In words: what the plan costs and saves against the shortest; empty for that itself."""
    plan_net = plan.plan_net
    shortest = quickest.plan_net
    if plan_net is shortest:
        return ""
    likelier = plan.on_time - quickest.on_time
    robots = set(plan_net.robots)
    others = set(shortest.robots)
    differences = [
        _more(plan_net.makespan_s - shortest.makespan_s, " s", "longer", "shorter"),
        _more(100 * likelier, " %", "likelier on time", "less likely on time")
        if abs(likelier) > LIKELIER
        else "",
        _exchanged(sorted(robots - others), sorted(others - robots)),
        _more(plan_net.distance_m - shortest.distance_m, " m", "more to drive", "less to drive"),
        _more(plan_net.energy_j - shortest.energy_j, " J", "more", "less"),
        _more(plan_net.clearances - shortest.clearances, "", "more to clear", "fewer to clear"),
    ]
    return ", ".join(filter(None, differences)) or "other actions, the same figures"


def _more(difference: float, unit: str, more: str, less: str) -> str:
    size = f"{abs(difference):.1f}".removesuffix(".0")
    return "" if size == "0" else f"{size}{unit} {more if difference > 0 else less}"


def _exchanged(new: Sequence[str], gone: Sequence[str]) -> str:
    if new and gone:
        return f"{enumeration(new)} instead of {enumeration(gone)}"
    return f"with {enumeration(new)}" if new else f"without {enumeration(gone)}" if gone else ""
