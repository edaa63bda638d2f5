"""The planner's knowledge base: plan-net actions with all slots of table 3, as checked data (MACTA §4-§5)."""

from planner.knowledge.action import ActionSpec, ParameterSpec, VariantSpec
from planner.knowledge.base import KnowledgeBase
from planner.knowledge.comparison import Comparison, Numbers, number_words
from planner.knowledge.expression import DURATION_SCALE, scale_term
from planner.knowledge.load import load_knowledge_base, read_knowledge_base, shipped_knowledge_base
from planner.knowledge.merge import KnowledgeBasePart, merge_knowledge_bases, read_knowledge_base_part
from planner.knowledge.operator import TEAM_SEPARATOR, GroundAction, Operator
from planner.knowledge.phases import Phase
from planner.knowledge.schema import KnowledgeBaseFile, PredicateSpec, QuantitySpec, TypeSpec

__all__ = [
    "DURATION_SCALE",
    "TEAM_SEPARATOR",
    "ActionSpec",
    "Comparison",
    "GroundAction",
    "KnowledgeBase",
    "KnowledgeBaseFile",
    "KnowledgeBasePart",
    "Numbers",
    "Operator",
    "ParameterSpec",
    "Phase",
    "PredicateSpec",
    "QuantitySpec",
    "TypeSpec",
    "VariantSpec",
    "load_knowledge_base",
    "merge_knowledge_bases",
    "number_words",
    "read_knowledge_base",
    "read_knowledge_base_part",
    "scale_term",
    "shipped_knowledge_base",
]
