"""A planning engine for the sample store that plans by rule: the first robots that reach a sample's way carry it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from planner import (
    UNOBSERVED,
    Fact,
    GroundAction,
    KnowledgeBase,
    Observer,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    keep_in_step,
    load_knowledge_base,
)
from planner.explanation.diagnosis import why_unsolvable
from planner.plan_nets.assembly import assemble
from planner.plan_nets.extraction import extract
from planner.plan_nets.orders import fewest_stages

CARRYING = ("NAVIGATE", "DOCK", "TRANSPORT", "RELEASE2")
INTERCHANGES = ("interchange_2", "interchange_1")


class StoreEngine:
    """Plans goals such as in(sample_1, bay_7), each sample over one interchange at most, one after the other, and
    charged(yard_1, charger_1).
    """

    name = "store rules"

    def __init__(self) -> None:
        self._base = load_knowledge_base()

    def plan(
        self, problem: PlanningProblem, request: PlanningRequest, observer: Observer = UNOBSERVED
    ) -> PlanningResult:
        steps = _Steps(self._base, problem)
        stages = fewest_stages(problem.goals, problem.after)
        if not all(steps.achieve(goal) for goal in sorted(problem.goals, key=lambda one: stages.get(one, 0))):
            return PlanningResult(
                status=PlanningStatus.UNSOLVABLE,
                engine=self.name,
                planning_s=0.0,
                reason=why_unsolvable(self._base, problem),
            )
        achieving = extract(steps.actions, problem.facts, problem.goals, after=problem.after)
        plan_net = assemble(
            achieving, problem.goals, self._base, {}, problem.deadlines_s, problem.not_before_s
        )
        return PlanningResult(
            status=PlanningStatus.SOLVED,
            engine=self.name,
            planning_s=0.0,
            plan_net=keep_in_step(plan_net, problem.facts, problem.objects, self._base),
        )


@dataclass
class _Steps:
    """The actions so far, and where they bring the robots."""

    base: KnowledgeBase
    problem: PlanningProblem
    actions: list[GroundAction] = field(default_factory=list)

    def __post_init__(self) -> None:
        facts = self.problem.facts
        self.at = {fact.args[0]: fact.args[2] for fact in facts if fact.predicate == "robot_position"}
        self.area = {fact.args[0]: fact.args[1] for fact in facts if fact.predicate == "in_area"}

    def achieve(self, goal: Fact) -> bool:
        """Carry the goal's sample to its place, or charge its robot; False if no robots can."""
        if goal.predicate != "object_position":
            return goal.predicate == "charged" and self._charge(*goal.args)
        sample, _, end = goal.args
        (start,) = (
            fact.args[2]
            for fact in self.problem.facts
            if fact.predicate == "object_position" and fact.args[0] == sample
        )
        if start == end:
            return True
        allowed = self.problem.recruits.get(goal, frozenset(self.at))
        ways = (way for way in self._ways(start, end) if allowed.issuperset(robot for robot, _, _ in way))
        legs = next(ways, ())
        for robot, source, target in legs:
            self._carry(robot, sample, source, target)
        return bool(legs)

    def _charge(self, robot: str, place: str) -> bool:
        needed = {Fact("can", (robot, "NAVIGATE")), Fact("reaches", (robot, place))}
        if not needed <= self.problem.facts:
            return False
        self._clear(place, robot)
        self._drive(robot, place)
        self._add("CHARGE", {"robot": robot, "rel": "near", "ref": place})
        return True

    def _ways(self, start: str, end: str) -> Iterator[Sequence[tuple[str, str, str]]]:
        """Who may carry something from where to where, best first."""
        for robot in self._reaching(start, end):
            yield ((robot, start, end),)
        for interchange in INTERCHANGES:
            for first in self._reaching(start, interchange):
                for second in self._reaching(interchange, end):
                    yield ((first, start, interchange), (second, interchange, end))

    def _reaching(self, *places: str) -> list[str]:
        facts = self.problem.facts
        return [
            robot
            for robot in sorted(self.at)
            if all(Fact("can", (robot, tag)) in facts for tag in CARRYING)
            and all(Fact("reaches", (robot, place)) in facts for place in places)
        ]

    def _carry(self, robot: str, sample: str, start: str, end: str) -> None:
        one = {"object": sample, "robots": robot}
        leg = {"rel1": "at", "ref1": start, "rel2": "near", "ref2": end}
        area = {"area": self.area[robot]}
        self._clear(start, robot)
        self._drive(robot, start)
        self._clear(end, robot)
        self._add("DOCK", {**one, "rel1": "near", "ref1": start})
        self._add("TRANSPORT", {**one, **leg, **area})
        self._add("RELEASE2", {**one, **leg})
        self.at[robot] = end

    def _clear(self, place: str, robot: str) -> None:
        """Send home whoever stands in the robot's way."""
        for other, standing in self.at.items():
            if other != robot and standing == place and self.area[other] == self.area[robot]:
                self._drive(other, f"home_{other}")

    def _drive(self, robot: str, end: str) -> None:
        if self.at[robot] != end:
            way = {"rel1": "near", "ref1": self.at[robot], "rel2": "near", "ref2": end}
            self._add("NAVIGATE", {"robots": robot, **way, "area": self.area[robot]})
            self.at[robot] = end

    def _add(self, tag: str, arguments: dict[str, str]) -> None:
        problem = self.problem
        self.actions.append(self.base.ground(tag, arguments, problem.functions, objects=problem.objects))
