"""A plan as the API and `macta plan --json` show it: facts in rel/ref form, seconds from the plan's start."""

from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field

from app.domain.goal_language.words import natural_key
from app.domain.lifecycles.plan import PlanState
from app.domain.plan_edits import GoalPin
from app.domain.tender_document import TenderBody
from app.domain.world_model.senses import why_cleared
from app.domain.world_model.vocabulary import planner_fact, symbolic, symbolic_all, types_in
from planner import (
    CausalLink,
    Distribution,
    Fact,
    Forecast,
    GoalForecast,
    Keeping,
    KnowledgeBase,
    LeftOut,
    Ordering,
    OrderingReason,
    PlanNet,
    PlanNetAction,
    PlanningResult,
    PreferenceChoice,
    PreferenceOutcome,
)
from planner.plan_nets.forecast import PROBABILITIES
from planner.repair import Course
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
    critical: bool = Field(default=False, description="it cannot start later without the plan ending later")
    distance_m: float = Field(default=0.0, description="driven by its robots together")
    energy_j: float = Field(default=0.0, description="used by its robots together")
    under_way: bool = Field(default=False, description="it is already being executed when the plan starts")
    not_before_s: float = Field(
        default=0.0, description="it starts then at the earliest, for a goal that is not to be true before"
    )
    phase: int = Field(default=0, description="which phase of the action it is, counted from 1; 0: all of it")
    phases: int = Field(default=0, description="how many phases the action has")
    level: float | None = Field(
        default=None,
        description="of an action that is there for a number, such as a battery: what that is to be at its end",
    )
    description: str


FACT_SLOTS = ("preconditions", "deletes", "intended_effects", "other_effects")
"""The fields of an action that hold facts; the others are the same in a plan-net and in its body."""


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
    kept_by: Keeping | None = Field(
        default=None, description="what keeps it while the robots carry the plan out alone"
    )
    why: str = Field(default="", description="why clearance keeps it; empty if something else does")


class LateGoalBody(PlanPart):
    """A goal that the plan reaches after its deadline."""

    goal: SymbolicFact
    late_s: float


class LeftOutBody(PlanPart):
    """An optional goal that the plan does not achieve."""

    goal: SymbolicFact
    value: float = Field(description="what it is worth")
    reason: str = Field(description="why it is left out")


class PreferenceBody(PlanPart):
    """A preference, and whether the plan keeps it."""

    preference: str = Field(description="the constraint, in words")
    cost_s: float = Field(description="what breaking it costs, in seconds of makespan")
    kept: bool
    reason: str = Field(default="", description="why it is broken; empty if it is kept")
    longer_s: float | None = Field(
        default=None,
        description="of a broken one: by so much longer is the shortest plan found that keeps it beside those kept; "
        "null if none was found",
    )
    longer_at_least_s: float = Field(
        default=0.0, description="of a broken one: proven, every such plan is longer by so much at least"
    )


class PreferencesBody(PlanPart):
    """Which preferences the plan keeps: by the smallest sum of makespan and costs of broken ones."""

    outcomes: tuple[PreferenceBody, ...]
    cost_s: float = Field(description="of the broken ones together")
    bound_s: float = Field(description="proven: no plan has a smaller sum of makespan and costs")
    cut_short: bool = Field(
        description="not every promising combination was tried: there may be a cheaper one"
    )

    @classmethod
    def of(cls, choice: PreferenceChoice) -> Self:
        return cls(
            outcomes=tuple(
                PreferenceBody(
                    preference=one.words,
                    cost_s=one.cost_s,
                    kept=one.is_kept,
                    reason=one.reason,
                    longer_s=one.longer_s,
                    longer_at_least_s=one.longer_at_least_s,
                )
                for one in choice.outcomes
            ),
            cost_s=choice.cost_s,
            bound_s=choice.bound_s,
            cut_short=choice.is_cut_short,
        )

    def to_choice(self) -> PreferenceChoice:
        """The choice that this body was made from."""
        return PreferenceChoice(
            outcomes=tuple(
                PreferenceOutcome(
                    words=one.preference,
                    cost_s=one.cost_s,
                    is_kept=one.kept,
                    reason=one.reason,
                    longer_s=one.longer_s,
                    longer_at_least_s=one.longer_at_least_s,
                )
                for one in self.outcomes
            ),
            bound_s=self.bound_s,
            is_cut_short=self.cut_short,
        )


class GoalForecastBody(PlanPart):
    """When a goal is likely achieved, seconds from the plan's start."""

    goal: SymbolicFact
    p10_s: float = Field(description="it is achieved by then with a probability of 10 %")
    p50_s: float
    p90_s: float
    deadline_s: float | None = Field(default=None, description="null if it has none")
    on_time: float | None = Field(default=None, ge=0, le=1, description="probability to keep its deadline")
    quantiles_s: tuple[float, ...] = Field(description="of its completion, at the forecast's `probabilities`")


class ForecastBody(PlanPart):
    """When the plan's goals are likely achieved if no action fails, by how far durations have varied."""

    goals: tuple[GoalForecastBody, ...]
    on_time: float | None = Field(
        default=None, ge=0, le=1, description="probability that every deadline is kept; null if there is none"
    )
    lateness_quantiles_s: tuple[float, ...] = Field(
        default=(), description="of how late the latest goal is, negative: early; empty without deadlines"
    )
    probabilities: tuple[float, ...] = PROBABILITIES
    made_at_s: float = Field(default=0.0, description="the start that deadlines count from, world's clock")
    delay_s: float = Field(
        default=0.0,
        description="how much later than that it starts: now, while it waits for a decision; else when its mission "
        "began; the chances are those of this start (0 without deadlines)",
    )

    @classmethod
    def of(cls, forecast: Forecast, knowledge_base: KnowledgeBase, *, made_at_s: float = 0.0) -> Self:
        return cls(
            goals=tuple(_goal_forecast(one, symbolic(one.goal, knowledge_base)) for one in forecast.goals),
            on_time=_rounded(forecast.on_time()),
            lateness_quantiles_s=() if forecast.lateness_s is None else forecast.lateness_s.quantiles,
            made_at_s=made_at_s,
        )

    def starting_at(self, start_s: float | None) -> Self:
        """The same with the chances of a start at that time of the world's clock; None: when it was to."""
        if start_s is None:
            return self
        delay_s = max(0.0, start_s - self.made_at_s)
        late = self.lateness_quantiles_s
        goals = [
            one.model_copy(
                update={"on_time": _rounded(_chance(one.quantiles_s, one.deadline_s, delay_s=delay_s))}
            )
            for one in self.goals
        ]
        return self.model_copy(
            update={
                "goals": tuple(goals),
                "on_time": _rounded(_chance(late, 0.0, delay_s=delay_s)) if late else None,
                "delay_s": round(delay_s, 3),
            }
        )


def _goal_forecast(one: GoalForecast, goal: SymbolicFact) -> GoalForecastBody:
    return GoalForecastBody(
        goal=goal,
        p10_s=one.completion_s.quantile(0.1),
        p50_s=one.completion_s.quantile(0.5),
        p90_s=one.completion_s.quantile(0.9),
        deadline_s=one.deadline_s,
        on_time=_rounded(one.on_time()),
        quantiles_s=one.completion_s.quantiles,
    )


def _chance(quantiles_s: tuple[float, ...], by_s: float | None, *, delay_s: float) -> float | None:
    if by_s is None:
        return None
    return Distribution(quantiles=quantiles_s).probability_up_to(by_s - delay_s)


def _rounded(chance: float | None) -> float | None:
    return None if chance is None else round(chance, 4)


class DifferenceBody(PlanPart):
    """How this plan differs from an old one, by the actions' old and new ids."""

    kept: dict[str, str] = Field(description="old id → new id: the same robots do the same in the same order")
    reassigned: dict[str, str] = Field(description="old id → new id: others do it")
    dropped: tuple[str, ...] = Field(description="old ids")
    added: tuple[str, ...]
    shifted: dict[str, float] = Field(description="new id → seconds later, negative: earlier")
    later_s: float = Field(description="how much later the plan ends")
    elapsed_s: float = Field(default=0.0, description="this plan's start on the old plan's time axis")
    words: tuple[str, ...]


class RepairsBody(PlanPart):
    """The plan that this one replaces, how it was repaired, and how it differs."""

    plan_id: str
    course: Course
    difference: DifferenceBody


class PlanBody(PlanPart):
    """A plan-net and the decision on it. `objects` gives the type of every name in the facts."""

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
    distance_m: float = Field(default=0.0, description="driven by all robots together")
    energy_j: float = Field(default=0.0, description="used by all robots together")
    critical_path: tuple[str, ...] = Field(
        default=(), description="a longest chain of actions: what the makespan is made of"
    )
    late: tuple[LateGoalBody, ...] = ()
    value: float | None = Field(
        default=None, description="what its optional goals are worth together; null without any"
    )
    value_bound: float | None = Field(
        default=None,
        description="no choice of optional goals that may have a plan is worth more; above `value` if the time was up",
    )
    left_out: tuple[LeftOutBody, ...] = Field(
        default=(), description="optional goals that it does not achieve, most worth first"
    )
    preferences: PreferencesBody | None = Field(
        default=None, description="which constraints that are only preferred it keeps; null without any"
    )
    forecast: ForecastBody | None = Field(
        default=None, description="null for plans that earlier versions have recorded"
    )
    clearances: int = Field(default=0, description="orderings for which a robot waits for clearance")
    senses: dict[str, tuple[str, ...]] = Field(
        default={},
        description="by robot, the predicates whose facts it senses; who is left out senses all that are sensed",
    )
    label: str = Field(default="", description="what it is best at among the goal's alternatives")
    comparison: str = Field(default="", description="what it costs and saves against the shortest of them")
    repairs: RepairsBody | None = Field(
        default=None, description="set if it replaces a stale plan, or is one that an operator has edited"
    )
    edits: tuple[GoalPin, ...] = Field(
        default=(), description="what operators have pinned of it; later repairs keep to it where they can"
    )
    tender: TenderBody | None = Field(
        default=None, description="who bid what for its legs and is awarded them; null without a contract net"
    )
    overtaken: tuple[str, ...] = Field(
        default=(),
        description="for a single proposed plan: its conditions that no longer hold, and what holds instead; if there "
        "are any, approving it has it repaired",
    )
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
        """The body of a plan-net; `particulars` are the fields that a plan-net does not have (id, world …)."""
        convert = _ToRelations(knowledge_base)
        cleared = why_cleared(net, knowledge_base)
        return cls.model_validate(
            {
                "goals": convert.all(net.goals),
                "actions": [convert.action(action) for action in net.actions],
                "causal_links": [
                    CausalLinkBody(
                        producer=link.producer, fact=convert.one(link.fact), consumer=link.consumer
                    )
                    for link in net.causal_links
                ],
                "orderings": [
                    OrderingBody(
                        before=o.before,
                        after=o.after,
                        reason=o.reason,
                        kept_by=o.kept_by,
                        why=cleared.get((o.before, o.after), ""),
                    )
                    for o in net.orderings
                ],
                "robots": sorted(net.robots, key=natural_key),
                "recruitment": dict(net.recruitment),
                "objects": types_in(_facts_of(net), knowledge_base),
                "makespan_s": net.makespan_s,
                "distance_m": net.distance_m,
                "energy_j": net.energy_j,
                "critical_path": net.critical_path,
                "clearances": net.clearances,
                "senses": {robot: sorted(words) for robot, words in net.senses.items()},
                "late": [LateGoalBody(goal=convert.one(goal), late_s=s) for goal, s in net.late.items()],
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
        left_out = [
            LeftOutBody(goal=symbolic(one.goal, knowledge_base), value=one.value, reason=one.reason)
            for one in result.left_out
        ]
        named = (*_facts_of(result.plan_net), *(one.goal for one in result.left_out))
        return cls.of_plan_net(
            result.plan_net,
            knowledge_base,
            engine=result.engine,
            planning_s=result.planning_s,
            lower_bound_s=result.lower_bound_s,
            value=result.value,
            value_bound=result.value_bound,
            left_out=left_out,
            preferences=None if result.preferences is None else PreferencesBody.of(result.preferences),
            objects=types_in(named, knowledge_base),
            **particulars,
        )

    def left_out_goals(self, knowledge_base: KnowledgeBase) -> tuple[LeftOut, ...]:
        """The optional goals that it leaves out, as planning has told them."""
        return tuple(
            LeftOut(
                goal=planner_fact(one.goal, knowledge_base, self.objects), value=one.value, reason=one.reason
            )
            for one in self.left_out
        )

    def to_plan_net(self, knowledge_base: KnowledgeBase) -> PlanNet:
        """The plan-net that this body was made from.

        :raises planner.KnowledgeBaseError: if its facts are not in the knowledge base's vocabulary.
        """
        convert = _FromRelations(knowledge_base, self.objects)
        return PlanNet(
            goals=convert.all(self.goals),
            actions=tuple(convert.action(action) for action in self.actions),
            causal_links=tuple(
                CausalLink(producer=link.producer, fact=convert.one(link.fact), consumer=link.consumer)
                for link in self.causal_links
            ),
            orderings=tuple(
                Ordering(before=o.before, after=o.after, reason=o.reason, kept_by=o.kept_by)
                for o in self.orderings
            ),
            recruitment=dict(self.recruitment),
            late={convert.one(late.goal): late.late_s for late in self.late},
            senses={robot: frozenset(words) for robot, words in self.senses.items()},
        )


def _facts_of(net: PlanNet) -> Iterable[Fact]:
    yield from net.goals
    for action in net.actions:
        yield from (*action.preconditions, *action.deletes, *action.effects)
    for link in net.causal_links:
        yield link.fact


class _ToRelations:
    """Converts from the planner's form to rel/ref form."""

    def __init__(self, knowledge_base: KnowledgeBase) -> None:
        self._knowledge_base = knowledge_base

    def one(self, fact: Fact) -> SymbolicFact:
        return symbolic(fact, self._knowledge_base)

    def all(self, facts: Iterable[Fact]) -> Facts:
        return symbolic_all(facts, self._knowledge_base)

    def action(self, action: PlanNetAction) -> ActionBody:
        slots = {name: getattr(action, name) for name in ActionBody.model_fields}
        return ActionBody.model_validate(slots | {slot: self.all(slots[slot]) for slot in FACT_SLOTS})


class _FromRelations:
    """Converts from rel/ref form to the planner's form."""

    def __init__(self, knowledge_base: KnowledgeBase, objects: Mapping[str, str]) -> None:
        self._knowledge_base = knowledge_base
        self._objects = objects

    def one(self, fact: SymbolicFact) -> Fact:
        return planner_fact(fact, self._knowledge_base, self._objects)

    def all(self, facts: Facts) -> tuple[Fact, ...]:
        return tuple(self.one(fact) for fact in facts)

    def action(self, action: ActionBody) -> PlanNetAction:
        slots: dict[str, Any] = {field.name: getattr(action, field.name) for field in fields(PlanNetAction)}
        return PlanNetAction(**slots | {slot: self.all(slots[slot]) for slot in FACT_SLOTS})
