"""The reflective agent's reasoning: knowledge base, planning problem, engines, plan-nets. Pure; imports
nothing of ours."""

from planner.engine import PlanningEngine, PlanningProblem, PlanningResult, PlanningStatus
from planner.errors import InvalidPlan, KnowledgeBaseError, PlannerError
from planner.execution import Violation, first_violation
from planner.fact import Fact
from planner.fast_downward import FastDownwardEngine
from planner.knowledge import GroundAction, KnowledgeBase, load_knowledge_base, read_knowledge_base
from planner.plan_net import GOAL, INITIAL, CausalLink, Ordering, OrderingReason, PlanNet, PlanNetAction
from planner.validation import faults_of, linearisation, replay

__all__ = [
    "GOAL",
    "INITIAL",
    "CausalLink",
    "Fact",
    "FastDownwardEngine",
    "GroundAction",
    "InvalidPlan",
    "KnowledgeBase",
    "KnowledgeBaseError",
    "Ordering",
    "OrderingReason",
    "PlanNet",
    "PlanNetAction",
    "PlannerError",
    "PlanningEngine",
    "PlanningProblem",
    "PlanningResult",
    "PlanningStatus",
    "Violation",
    "faults_of",
    "first_violation",
    "linearisation",
    "load_knowledge_base",
    "read_knowledge_base",
    "replay",
]
