"""An explanation as the API and `macta plan --explain` show it: facts in rel/ref form, reasons as sentences."""

from typing import Self

from pydantic import BaseModel, ConfigDict, Field

from app.domain.plan_document import CausalLinkBody
from app.domain.world_model.vocabulary import symbolic, symbolic_all
from planner import KnowledgeBase
from planner.explanation import ActionExplanation, Explanation
from robots.wire import SymbolicFact


class ExplanationPart(BaseModel):
    model_config = ConfigDict(frozen=True, allow_inf_nan=False)


class ActionExplanationBody(ExplanationPart):
    """Why an action is there, by these robots, and in this place of the order."""

    action: str
    goals: tuple[SymbolicFact, ...] = Field(description="the goals that it serves")
    chain: tuple[CausalLinkBody, ...] = Field(description="the links by which it serves one of them")
    because: tuple[str, ...] = Field(description="the chain in words")
    robots: dict[str, str] = Field(description="for each of its robots, why no other was chosen")
    order: tuple[str, ...] = Field(description="what it comes after, then what it comes before, and why")
    after: tuple[str, ...] = Field(
        default=(), description="the actions it comes after; the first sentences of `order` say why, one each"
    )

    @classmethod
    def of(cls, explained: ActionExplanation, knowledge_base: KnowledgeBase) -> Self:
        return cls(
            action=explained.action,
            goals=symbolic_all(explained.goals, knowledge_base),
            chain=tuple(
                CausalLinkBody(
                    producer=link.producer, fact=symbolic(link.fact, knowledge_base), consumer=link.consumer
                )
                for link in explained.chain
            ),
            because=explained.because,
            robots=dict(explained.robots),
            order=explained.order,
            after=explained.after,
        )


class WaitBody(ExplanationPart):
    """A robot stands idle before `action` until `awaited` has ended, if every action starts at its earliest."""

    robot: str
    action: str
    awaited: str
    from_s: float
    span_s: float
    words: str


class ConstraintCostBody(ExplanationPart):
    """What a constraint costs a plan that keeps it."""

    constraint: str = Field(description="in words")
    at_least_s: float = Field(description="by so much the shortest plan that was found without it is shorter")
    at_most_s: float | None = Field(description="by more no plan without it is shorter; null: not known")
    words: str


class ExplanationBody(ExplanationPart):
    """Why a plan-net is as it is."""

    plan_id: str = ""
    actions: tuple[ActionExplanationBody, ...]
    constraints: tuple[ConstraintCostBody, ...] = Field(
        default=(), description="what each constraint costs; those that no time was left for are missing"
    )
    robots: dict[str, str] = Field(description="by robot, the cost of planning without it, in words")
    makespan: tuple[str, ...] = Field(description="the critical path in words")
    waits: tuple[WaitBody, ...] = Field(description="where robots wait for others, the longest first")

    @classmethod
    def of(cls, explanation: Explanation, knowledge_base: KnowledgeBase, *, plan_id: str = "") -> Self:
        return cls(
            plan_id=plan_id,
            actions=tuple(ActionExplanationBody.of(one, knowledge_base) for one in explanation.actions),
            constraints=tuple(
                ConstraintCostBody(**{name: getattr(cost, name) for name in ConstraintCostBody.model_fields})
                for cost in explanation.constraints
            ),
            robots=dict(explanation.robots),
            makespan=explanation.makespan,
            waits=tuple(
                WaitBody(**{name: getattr(wait, name) for name in WaitBody.model_fields})
                for wait in explanation.waits
            ),
        )
