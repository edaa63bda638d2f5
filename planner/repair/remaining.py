"""The rest of a plan-net that is being carried out, and the remaining problem.

An action that is under way has made its deletes but not its effects. So that it stays an action of the plan-net like
any other, the problem states the facts as of its start: what it needed and has deleted is put back. It is first in
the sequence, hence no other action relies on what it deletes again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from planner.engines.peripherals import attend
from planner.engines.plan_net_completion import complete_plan_net, confirm
from planner.engines.replenishment import Outside, Replenishment
from planner.errors import InvalidPlan, KnowledgeBaseError, UnknownAction
from planner.explanation.legs import barred_actions
from planner.fact import Fact
from planner.knowledge import GroundAction, KnowledgeBase
from planner.plan_nets.extraction import fault_of
from planner.plan_nets.plan_net import ROUNDING_S, PlanNet, PlanNetAction
from planner.plan_nets.progression import progressed
from planner.plan_nets.validation import linearisation
from planner.problem.interface import PlanningProblem
from planner.problem.static_facts import StaticFacts
from planner.problem.zones import ground_action, ground_again


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionProgress:
    """How far a plan-net has been carried out.

    :param done: ids of the actions that have ended.
    :param under_way: id → seconds left, of the actions that run and are expected to end well.
    :param lost: robots that must no longer be recruited; what they do counts as not done.
    :param elapsed_s: since the plan's start.
    """

    done: frozenset[str] = frozenset()
    under_way: Mapping[str, float] = field(default_factory=dict)
    lost: frozenset[str] = frozenset()
    elapsed_s: float = 0.0


NOT_BEGUN = MissionProgress()


class Remaining:
    """The actions of a plan-net that have not ended.

    `problem`: the one that plan-nets from now on solve, with the facts as of the start of what is under way, without
    the static facts of lost robots. `actions`: as in the plan-net. `under_way` and `rest`: as the knowledge base
    grounds them now, in an order of the plan-net; `rest` lacks those that it can no longer ground, and those
    that may no longer serve their goals (`planner.explanation.legs.barred_actions`).
    """

    def __init__(
        self,
        plan_net: PlanNet,
        problem: PlanningProblem,
        progress: MissionProgress,
        knowledge_base: KnowledgeBase,
    ) -> None:
        """:param problem: the present facts, and all the goals from now on.
        :raises UnknownAction: if the progress names actions that the plan-net lacks.
        """
        _refuse_unknown(plan_net, progress)
        self.knowledge_base = knowledge_base
        self.progress = progress
        self.goals = frozenset(problem.goals)
        able = StaticFacts(knowledge_base, problem).without(progress.lost)
        self.actions = tuple(a for a in linearisation(plan_net) if a.id not in progress.done)
        barred = barred_actions(plan_net, problem, knowledge_base).keys() - progress.under_way.keys()
        left = [
            (a, ground)
            for a in self.actions
            if a.id not in barred and (ground := self._ground(a, able)) is not None
        ]
        self.under_way = tuple(
            _begun(ground, progress.under_way[action.id])
            for action, ground in left
            if self._runs_on(action, ground, able)
        )
        self.rest = tuple(ground for action, ground in left if not self._runs_on(action, ground, able))
        began = {f for action in self.under_way for f in action.deletes if f in action.preconditions}
        self.problem = replace(able, facts=able.facts | began)
        self._statics = StaticFacts(knowledge_base, self.problem)

    def after(self, sequence: Sequence[GroundAction]) -> PlanningProblem:
        """The problem as it is after a sequence that can be carried out."""
        return replace(self.problem, facts=progressed(self.problem.facts, sequence))

    def finished(self, sequence: Sequence[GroundAction], goals: Sequence[Fact]) -> PlanNet | str:
        """The plan-net of a sequence for these goals, checked and confirmed; or, in words, why there is none."""
        attended = attend(sequence, replace(self.problem, goals=tuple(goals)), self.knowledge_base)
        problem = replace(self.problem, goals=attended.goals)
        sequence = attended.sequence
        if (fault := fault_of(sequence, problem.facts, problem.goals)) is not None:
            return fault
        try:
            plan_net = complete_plan_net(sequence, problem, self.knowledge_base, self._statics)
            if isinstance(plan_net, PlanNet):
                confirm(plan_net, problem, self.knowledge_base)
        except InvalidPlan as error:
            return str(error)
        if isinstance(plan_net, str):
            return plan_net
        replenishment = Replenishment(problem, self.knowledge_base)
        supplied = replenishment.supplied(replenishment.sized(plan_net))
        return supplied.why if isinstance(supplied, Outside) else self._refused(supplied) or supplied

    def _refused(self, plan_net: PlanNet) -> str:
        """Why a valid plan-net cannot be used; empty if it can."""
        if lost := sorted(self.progress.lost.intersection(plan_net.robots)):
            return f"{', '.join(lost)} must not be recruited"
        held_up = (a for a in plan_net.actions if a.under_way and a.earliest_start_s > ROUNDING_S)
        if (one := next(held_up, None)) is not None:
            return f"{one.id} {one.tag} is under way, yet would wait"
        under_way = {a.id for a in plan_net.actions if a.under_way}
        barred = barred_actions(plan_net, self.problem, self.knowledge_base)
        return next((why for action, why in barred.items() if action not in under_way), "")

    def _ground(self, action: PlanNetAction, problem: PlanningProblem) -> GroundAction | None:
        """The action with its duration as expected now; None if it is no longer possible."""
        if not self.progress.lost.isdisjoint(action.agents):
            return None
        try:
            if self.goals.isdisjoint(action.intended_effects) or action.id in self.progress.under_way:
                return ground_again(action, problem, self.knowledge_base)
            return ground_action(
                action.tag, action.arguments, problem, self.knowledge_base, phase=action.phase
            )
        except KnowledgeBaseError:
            return None

    def _runs_on(self, action: PlanNetAction, ground: GroundAction, problem: PlanningProblem) -> bool:
        """True if it is under way and what it needs until its end still holds."""
        needs = set(ground.preconditions) - set(ground.deletes)
        return action.id in self.progress.under_way and problem.facts.issuperset(needs)


def in_order(plan_net: PlanNet) -> tuple[PlanNetAction, ...]:
    """The actions of a plan-net in one of its orders, those under way first."""
    return tuple(sorted(linearisation(plan_net), key=lambda action: not action.under_way))


def _begun(action: GroundAction, left_s: float) -> GroundAction:
    """The rest of an action."""
    seconds = round(max(left_s, 0.0), 3)
    share = min(1.0, seconds / action.duration_s) if action.duration_s else 0.0
    return replace(
        action,
        under_way=True,
        duration_s=seconds,
        distance_m=round(share * action.distance_m, 3),
        energy_j=round(share * action.energy_j, 3),
    )


def _refuse_unknown(plan_net: PlanNet, progress: MissionProgress) -> None:
    known = [action.id for action in plan_net.actions]
    if unknown := sorted({*progress.done, *progress.under_way}.difference(known)):
        raise UnknownAction(f"the plan-net has no action {', '.join(unknown)}; it has {', '.join(known)}")
