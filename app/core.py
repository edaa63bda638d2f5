"""What every desk and workflow works on: the record, its events and facts, durable work, and the vocabulary."""

from dataclasses import dataclass

from app.database import Database
from app.durable import Workflows
from app.events import EventLog
from app.plans.active import Holdings
from app.plans.nets import PlanNets
from app.world_model.store import FactStore
from planner import KnowledgeBase


@dataclass(frozen=True, slots=True, kw_only=True)
class Core:
    database: Database
    events: EventLog
    facts: FactStore
    workflows: Workflows
    knowledge_base: KnowledgeBase
    plan_nets: PlanNets
    holdings: Holdings
