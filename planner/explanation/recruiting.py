"""Why this robot and not another: what keeps the others from its actions, and what a plan without it costs."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence

from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.knowledge.phrases import denial, enumeration, naturally_sorted, nothing, phrase
from planner.plan_nets.plan_net import PlanNet, PlanNetAction
from planner.problem.interface import PlanningProblem, PlanningResult, PlanningStatus
from planner.problem.solving import TimeLimitedEngine
from planner.problem.static_facts import StaticFacts
from planner.relaxation import Relaxation


def recruitment_of(actions: Sequence[GroundAction], statics: StaticFacts) -> dict[str, str]:
    """A sentence for each robot: what it is to do and can, what it reaches, and who else would qualify."""
    work: dict[str, list[GroundAction]] = defaultdict(list)
    for action in actions:
        for agent in action.agents:
            work[agent].append(action)
    return {robot: _sentence(robot, work, statics) for robot in sorted(work)}


def robots_by_work(plan_net: PlanNet) -> list[str]:
    """The plan's robots, those with the most to do first."""
    work_s: dict[str, float] = defaultdict(float)
    for action in plan_net.actions:
        for robot in action.agents:
            work_s[robot] += action.duration_s
    return sorted(work_s, key=lambda robot: (-work_s[robot], robot))


def _sentence(robot: str, work: Mapping[str, Sequence[GroundAction]], statics: StaticFacts) -> str:
    mine = work[robot]
    tags = list(dict.fromkeys(action.tag for action in mine))
    if robot in statics.peripherals:
        return f"can {enumeration(tags, most=len(tags))}; the plan's ways and places ask for it"
    needed = {fact for action in mine for fact in action.preconditions if fact in statics.facts}
    places = naturally_sorted(
        {arg for fact in needed for arg in fact.args if arg in statics.objects} - {robot}
    )
    others = [
        other for other in statics.robots if other != robot and statics.obstacle(other, needed, robot) is None
    ]
    idle = [other for other in others if other not in work]
    busy = [other for other in others if other in work]
    rivals = [
        f"{enumeration(idle)} would qualify too, the plan found has no need of it" if idle else "",
        f"{enumeration(busy)} would qualify too but {'has' if len(busy) == 1 else 'have'} other work"
        if busy
        else "",
    ]
    serves = f" and serves {enumeration(places)}" if places else ""
    alone = "no other robot qualifies"
    return f"can {enumeration(tags, most=len(tags))}{serves}; {'; '.join(filter(None, rivals)) or alone}"


MAX_TRIALS = 8
"""Maximum number of robots to plan without, those with the most to do first."""
MAX_NAMED = 3


def trials(plan_net: PlanNet, statics: StaticFacts, solving: TimeLimitedEngine) -> Mapping[str, str]:
    """By robot, in words, what the best plan found without it costs, or why there is none; while time is left."""
    found: dict[str, str] = {}
    for robot in robots_by_work(plan_net)[:MAX_TRIALS]:
        result = solving.plan_if_time(statics.without({robot}))
        if result is not None:
            found[robot] = _trial(robot, result, plan_net)
    return found


def _trial(robot: str, result: PlanningResult, plan_net: PlanNet) -> str:
    other = result.plan_net
    if other is not None and robot not in other.robots:
        new = naturally_sorted(set(other.robots) - set(plan_net.robots))
        instead = f"{enumeration(new)} instead of {robot}" if new else f"the others without {robot}"
        longer_s = other.makespan_s - plan_net.makespan_s
        return f"{instead}: {longer_s:+.1f} s"
    if result.status is PlanningStatus.UNSOLVABLE or other is not None:
        why = f": then {result.reason}" if result.reason else ""
        return f"there is no plan without {robot}{why}"
    return f"no plan without {robot} was found ({result.reason})"


class Rivals:
    """Which other robots could do a plan's actions: static facts permit it, and they can get to where it is done."""

    def __init__(self, plan_net: PlanNet, problem: PlanningProblem, knowledge_base: KnowledgeBase) -> None:
        self.statics = StaticFacts(knowledge_base, problem)
        self.knowledge_base = knowledge_base
        asked = {
            fact.predicate
            for action in plan_net.actions
            for robot in action.agents
            for fact in self._states(action, robot)
        }
        self._relaxation = Relaxation(knowledge_base, problem, observed=asked)
        self._relaxation.run()

    def obstacle(self, other: str, action: PlanNetAction, robot: str) -> Fact | None:
        """A fact that cannot hold with `other` in the robot's place; None if nothing keeps it from the action."""
        fact = self.statics.obstacle(other, action.preconditions, robot)
        if fact is not None:
            return fact
        states = (fact.renamed({robot: other}) for fact in self._states(action, robot))
        return next((fact for fact in states if not self._relaxation.holds(fact)), None)

    def _states(self, action: PlanNetAction, robot: str) -> Iterator[Fact]:
        """What the action needs of the robot alone and actions bring about, such as where it is.

        Nothing if the action moves the robot alone: others come from elsewhere.
        """
        if not any(arg in self.statics.things for fact in action.intended_effects for arg in fact.args):
            return
        # What is said of a robot and a thing would be too many facts to ask for.
        beside = self.statics.things.union(action.agents) - {robot}
        for fact in action.preconditions:
            is_state = fact.predicate in self.knowledge_base.fluents and robot in fact.args
            if is_state and beside.isdisjoint(fact.args):
                yield fact


def why_this_robot(
    action: PlanNetAction, robot: str, rivals: Rivals, trial: str | None, withheld: Mapping[Fact, str]
) -> str:
    """In words, what keeps the other robots from the action in this robot's place, and what one of them costs.

    :param withheld: facts that do not count though they hold, each with why, in words.
    """
    obstacles: dict[str, Fact] = {}
    able: list[str] = []
    kept: list[str] = []
    for other in naturally_sorted(set(rivals.statics.robots) - set(action.agents)):
        fact = rivals.obstacle(other, action, robot)
        if fact is None:
            able.append(other)
        elif fact in withheld:
            kept.append(withheld[fact])
        else:
            obstacles[other] = fact
    reasons = [*kept, *_kept_away(obstacles, rivals.knowledge_base, alone=not able and not kept)]
    if able and trial is not None:
        reasons.insert(0, trial)
    elif able:
        reasons.insert(0, f"{enumeration(able)} could do it, too")
    return "; ".join(reasons) or "there is no other robot"


def _kept_away(obstacles: Mapping[str, Fact], knowledge_base: KnowledgeBase, *, alone: bool) -> Iterator[str]:
    """What keeps robots from the action, each obstacle once."""
    groups: dict[tuple[str, tuple[str, ...]], list[str]] = defaultdict(list)
    for robot, fact in obstacles.items():
        groups[fact.predicate, tuple("" if arg == robot else arg for arg in fact.args)].append(robot)
    for (predicate, args), robots in groups.items():
        first = Fact(predicate, tuple(arg or robots[0] for arg in args))
        if alone and len(groups) == 1 and predicate not in knowledge_base.fluents:
            yield nothing(knowledge_base, first, args.index(""), "other robot")
        else:
            yield _denied(first, robots, knowledge_base)


def _denied(fact: Fact, robots: Sequence[str], knowledge_base: KnowledgeBase) -> str:
    alike = f" (likewise {enumeration(robots[1:], most=MAX_NAMED)})" if robots[1:] else ""
    if fact.predicate in knowledge_base.fluents:
        return f"nothing brings about that {phrase(knowledge_base, fact)}{alike}"
    return denial(knowledge_base, fact) + alike
