"""The parts that most services share: database, events, facts, workflows and knowledge base."""

from dataclasses import dataclass

from app.store import Database
from app.store.event_log import EventLog
from app.store.facts import FactStore
from app.store.plan_nets import PlanNets
from app.store.reservations import Reservations
from app.workflows import Workflows
from planner import KnowledgeBase


@dataclass(frozen=True, slots=True, kw_only=True)
class Core:
    """Created by the composition root, passed to services."""

    database: Database
    events: EventLog
    facts: FactStore
    workflows: Workflows
    knowledge_base: KnowledgeBase
    plan_nets: PlanNets
    reservations: Reservations
