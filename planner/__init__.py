"""The reflective agent's reasoning: knowledge base, planning problem, engines, plan-nets.

Pure: does no I/O of the service and imports no other package of ours. The rooms in order, each of which imports only
those before it: `knowledge`, `plan_nets`, `problem`, `relaxation`, `bounds`, `explanation`, `interchange`, `engines`,
`repair`.
"""

from planner.errors import InvalidPlan, KnowledgeBaseError, PlannerError
from planner.fact import Fact
from planner.knowledge import (
    TEAM_SEPARATOR,
    GroundAction,
    KnowledgeBase,
    Numbers,
    QuantitySpec,
    load_knowledge_base,
    merge_knowledge_bases,
    number_words,
    read_knowledge_base,
    read_knowledge_base_part,
    scale_term,
    shipped_knowledge_base,
)
from planner.plan_nets.forecast import Distribution, Forecast, GoalForecast, Spread, Spreads
from planner.plan_nets.plan_net import (
    GOAL,
    INITIAL,
    CausalLink,
    Keeping,
    Ordering,
    OrderingReason,
    PlanNet,
    PlanNetAction,
    Senses,
)
from planner.plan_nets.synchronisation import awaits_of, keep_in_step
from planner.plan_nets.validation import faults_of
from planner.problem.interface import (
    KEPT_S,
    UNOBSERVED,
    Access,
    Crossing,
    LeftOut,
    Objective,
    Observer,
    PlanningEngine,
    PlanningProblem,
    PlanningRequest,
    PlanningResult,
    PlanningStatus,
    Progress,
    warm_up,
)
from planner.problem.preference import Preference, PreferenceChoice, PreferenceOutcome
from planner.up_registration import register_with_unified_planning

__all__ = [
    "GOAL",
    "INITIAL",
    "KEPT_S",
    "TEAM_SEPARATOR",
    "UNOBSERVED",
    "Access",
    "CausalLink",
    "Crossing",
    "Distribution",
    "Fact",
    "Forecast",
    "GoalForecast",
    "GroundAction",
    "InvalidPlan",
    "Keeping",
    "KnowledgeBase",
    "KnowledgeBaseError",
    "LeftOut",
    "Numbers",
    "Objective",
    "Observer",
    "Ordering",
    "OrderingReason",
    "PlanNet",
    "PlanNetAction",
    "PlannerError",
    "PlanningEngine",
    "PlanningProblem",
    "PlanningRequest",
    "PlanningResult",
    "PlanningStatus",
    "Preference",
    "PreferenceChoice",
    "PreferenceOutcome",
    "Progress",
    "QuantitySpec",
    "Senses",
    "Spread",
    "Spreads",
    "awaits_of",
    "faults_of",
    "keep_in_step",
    "load_knowledge_base",
    "merge_knowledge_bases",
    "number_words",
    "read_knowledge_base",
    "read_knowledge_base_part",
    "register_with_unified_planning",
    "scale_term",
    "shipped_knowledge_base",
    "warm_up",
]
