"""The explanation of a plan-net as a whole."""

from collections.abc import Mapping
from dataclasses import dataclass

from planner.explanation.constraining import ConstraintCost, constraint_costs
from planner.explanation.ordering import Reasons
from planner.explanation.purpose import chain_in_words, purposes
from planner.explanation.recruiting import Rivals, trials, why_this_robot
from planner.explanation.timing import Wait, makespan, waits
from planner.fact import Fact
from planner.knowledge import KnowledgeBase
from planner.plan_nets.plan_net import CausalLink, PlanNet
from planner.problem.interface import UNOBSERVED, Observer, PlanningEngine, PlanningProblem, PlanningRequest
from planner.problem.solving import TimeLimitedEngine

NOTHING: Mapping[Fact, str] = {}
UNCONSTRAINED: Mapping[str, PlanningProblem] = {}


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionExplanation:
    """Why an action is in the plan, and where it is.

    `goals` are those it serves, `chain` the links that lead to one of them, `because` the same in sentences;
    `robots`: for each of its robots why not another; `order`: sentences on what it comes after and before, and why;
    `after`: the actions that the first of these sentences are about, one each.
    """

    action: str
    goals: tuple[Fact, ...]
    chain: tuple[CausalLink, ...]
    because: tuple[str, ...]
    robots: Mapping[str, str]
    order: tuple[str, ...]
    after: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Explanation:
    """Why a plan-net is as it is.

    `constraints` and `robots` say what it costs to keep each constraint, and to do without each robot, that was tried;
    `makespan` is the critical path in words.
    """

    actions: tuple[ActionExplanation, ...]
    constraints: tuple[ConstraintCost, ...]
    robots: Mapping[str, str]
    makespan: tuple[str, ...]
    waits: tuple[Wait, ...]

    def of(self, action_id: str) -> ActionExplanation:
        return next(action for action in self.actions if action.action == action_id)


def explain(
    plan_net: PlanNet,
    problem: PlanningProblem,
    knowledge_base: KnowledgeBase,
    engine: PlanningEngine | None,
    request: PlanningRequest | None = None,
    observer: Observer = UNOBSERVED,
    *,
    withheld: Mapping[Fact, str] = NOTHING,
    without: Mapping[str, PlanningProblem] = UNCONSTRAINED,
) -> Explanation:
    """Why the plan-net is as it is.

    :param problem: the plan-net's.
    :param engine: solves the problem again without each constraint and each robot, to find what that costs; None: not
        explained.
    :param withheld: facts that the problem leaves out though they hold, each with why, in words.
    :param without: by constraint, in words, the problem without that one.
    :param request: for these trials; its time limit is for all of them together.
    """
    names = {action.id: f"{action.id} {action.tag}" for action in plan_net.actions}
    reasons = Reasons(plan_net, names, knowledge_base)
    rivals = Rivals(plan_net, problem, knowledge_base)
    tried: Mapping[str, str] = {}
    costs: tuple[ConstraintCost, ...] = ()
    if engine is not None:
        solving = TimeLimitedEngine(engine, request or PlanningRequest(), observer)
        costs = constraint_costs(plan_net, without, solving)
        tried = trials(plan_net, rivals.statics, solving)
    order = _orders(plan_net, names, reasons)
    purpose = purposes(plan_net, knowledge_base)
    return Explanation(
        actions=tuple(
            ActionExplanation(
                action=action.id,
                goals=purpose[action.id].goals,
                chain=purpose[action.id].chain,
                because=tuple(chain_in_words(purpose[action.id], names, knowledge_base)),
                robots={
                    robot: why_this_robot(action, robot, rivals, tried.get(robot), withheld)
                    for robot in action.agents
                },
                order=tuple(order[action.id]),
                after=tuple(one.before for one in plan_net.orderings if one.after == action.id),
            )
            for action in plan_net.actions
        ),
        constraints=costs,
        robots=dict(sorted(tried.items())),
        makespan=makespan(plan_net, names, reasons),
        waits=waits(plan_net, names, reasons),
    )


def _orders(plan_net: PlanNet, names: Mapping[str, str], reasons: Reasons) -> Mapping[str, list[str]]:
    """For each action what it comes after, then what it comes before."""
    order: dict[str, list[str]] = {action.id: [] for action in plan_net.actions}
    for ordering in plan_net.orderings:
        order[ordering.after].append(f"after {names[ordering.before]}: {reasons.why(ordering)}")
    for ordering in plan_net.orderings:
        order[ordering.before].append(f"before {names[ordering.after]}: {reasons.why(ordering)}")
    return order
