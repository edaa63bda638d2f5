"""A plan as the API and `macta plan --json` show it: facts in rel/ref form, seconds from the plan's start."""

from collections.abc import Iterable, Mapping
from typing import Self

from pydantic import BaseModel, ConfigDict, Field

from app.states import PlanState
from app.vocabulary import planner_fact, symbolic, symbolic_all, types_in
from planner import (
    CausalLink,
    Fact,
    KnowledgeBase,
    Ordering,
    OrderingReason,
    PlanNet,
    PlanNetAction,
    PlanningResult,
)
from robots.wire import SymbolicFact

Facts = tuple[SymbolicFact, ...]


class PlanPart(BaseModel):
    model_config = ConfigDict(frozen=True, allow_inf_nan=False)


class ActionBody(PlanPart):
    """A ground plan-net action (table 3) with its time window."""

    id: str
    tag: str
    arguments: dict[str, str]
    agents: tuple[str, ...]
    preconditions: Facts
    deletes: Facts
    intended_effects: Facts
    other_effects: Facts
    duration_s: float
    earliest_start_s: float
    latest_start_s: float
    earliest_end_s: float
    slack_s: float
    description: str


class CausalLinkBody(PlanPart):
    """`producer` brings about what `consumer` needs; `initial` and `goal` are the two ends of the plan."""

    producer: str
    fact: SymbolicFact
    consumer: str


class OrderingBody(PlanPart):
    """`before` ends before `after` starts."""

    before: str
    after: str
    reason: OrderingReason


class PlanBody(PlanPart):
    """A plan-net and the decision on it. `objects` gives the type of every name the facts speak of."""

    id: str = ""
    goal_id: str | None = None
    world: str = ""
    state: PlanState = PlanState.PROPOSED
    reason: str = ""
    goals: Facts
    actions: tuple[ActionBody, ...]
    causal_links: tuple[CausalLinkBody, ...]
    orderings: tuple[OrderingBody, ...]
    robots: tuple[str, ...]
    recruitment: dict[str, str]
    objects: dict[str, str]
    makespan_s: float
    engine: str = ""
    planning_s: float = 0.0
    lower_bound_s: float | None = None
    world_version: int | None = Field(default=None, description="of the facts the plan was made from")
    created_at: str | None = None
    decided_at: str | None = None
    decided_by: str | None = None
    comment: str | None = None

    @classmethod
    def of_plan_net(cls, net: PlanNet, knowledge_base: KnowledgeBase, **particulars: object) -> Self:
        """The body of a plan-net; `particulars` are the fields that it does not hold (id, world …)."""
        form = _Form(knowledge_base)
        return cls.model_validate(
            {
                "goals": form.all(net.goals),
                "actions": [form.action(action) for action in net.actions],
                "causal_links": [
                    CausalLinkBody(producer=link.producer, fact=form.one(link.fact), consumer=link.consumer)
                    for link in net.causal_links
                ],
                "orderings": [
                    OrderingBody(before=o.before, after=o.after, reason=o.reason) for o in net.orderings
                ],
                "robots": net.robots,
                "recruitment": dict(net.recruitment),
                "objects": types_in(_facts_of(net), knowledge_base),
                "makespan_s": net.makespan_s,
                **particulars,
            }
        )

    @classmethod
    def of_result(cls, result: PlanningResult, knowledge_base: KnowledgeBase, **particulars: object) -> Self:
        """The body of an engine's solution.

        :raises ValueError: if the result is not a solution.
        """
        if result.plan_net is None:
            raise ValueError(f"no plan in a result that is {result.status}: {result.reason}")
        return cls.of_plan_net(
            result.plan_net,
            knowledge_base,
            engine=result.engine,
            planning_s=result.planning_s,
            lower_bound_s=result.lower_bound_s,
            **particulars,
        )

    def to_plan_net(self, knowledge_base: KnowledgeBase) -> PlanNet:
        """The plan-net this is the body of, exactly.

        :raises planner.KnowledgeBaseError: if the knowledge base does not know its facts.
        """
        back = _Back(knowledge_base, self.objects)
        return PlanNet(
            goals=back.all(self.goals),
            actions=tuple(back.action(action) for action in self.actions),
            causal_links=tuple(
                CausalLink(producer=link.producer, fact=back.one(link.fact), consumer=link.consumer)
                for link in self.causal_links
            ),
            orderings=tuple(
                Ordering(before=o.before, after=o.after, reason=o.reason) for o in self.orderings
            ),
            recruitment=dict(self.recruitment),
        )


def _facts_of(net: PlanNet) -> Iterable[Fact]:
    yield from net.goals
    for action in net.actions:
        yield from (*action.preconditions, *action.deletes, *action.effects)
    for link in net.causal_links:
        yield link.fact


class _Form:
    """Planner's form to rel/ref form."""

    def __init__(self, knowledge_base: KnowledgeBase) -> None:
        self._knowledge_base = knowledge_base

    def one(self, fact: Fact) -> SymbolicFact:
        return symbolic(fact, self._knowledge_base)

    def all(self, facts: Iterable[Fact]) -> Facts:
        return symbolic_all(facts, self._knowledge_base)

    def action(self, action: PlanNetAction) -> ActionBody:
        return ActionBody(
            id=action.id,
            tag=action.tag,
            arguments=dict(action.arguments),
            agents=action.agents,
            preconditions=self.all(action.preconditions),
            deletes=self.all(action.deletes),
            intended_effects=self.all(action.intended_effects),
            other_effects=self.all(action.other_effects),
            duration_s=action.duration_s,
            earliest_start_s=action.earliest_start_s,
            latest_start_s=action.latest_start_s,
            earliest_end_s=action.earliest_end_s,
            slack_s=action.slack_s,
            description=action.description,
        )


class _Back:
    """Rel/ref form to planner's form."""

    def __init__(self, knowledge_base: KnowledgeBase, objects: Mapping[str, str]) -> None:
        self._knowledge_base, self._objects = knowledge_base, objects

    def one(self, fact: SymbolicFact) -> Fact:
        return planner_fact(fact, self._knowledge_base, self._objects)

    def all(self, facts: Facts) -> tuple[Fact, ...]:
        return tuple(self.one(fact) for fact in facts)

    def action(self, action: ActionBody) -> PlanNetAction:
        return PlanNetAction(
            id=action.id,
            tag=action.tag,
            arguments=dict(action.arguments),
            agents=action.agents,
            preconditions=self.all(action.preconditions),
            deletes=self.all(action.deletes),
            intended_effects=self.all(action.intended_effects),
            other_effects=self.all(action.other_effects),
            duration_s=action.duration_s,
            earliest_start_s=action.earliest_start_s,
            latest_start_s=action.latest_start_s,
            description=action.description,
        )
