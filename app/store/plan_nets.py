"""Plan-nets read back from the record, the newest kept in memory: a plan never changes once it is recorded."""

from collections import OrderedDict
from threading import Lock

from sqlalchemy.orm import Session

from app.domain.plan_document import PlanBody
from app.store import PlanRow
from planner import KnowledgeBase, PlanNet

REMEMBERED = 200
"""So many plan-nets are kept."""


class PlanNets:
    """Thread-safe."""

    def __init__(self, knowledge_base: KnowledgeBase) -> None:
        self._knowledge_base, self._lock = knowledge_base, Lock()
        self._known: OrderedDict[str, PlanNet] = OrderedDict()

    def of(self, session: Session, plan_id: str) -> PlanNet:
        """:raises planner.KnowledgeBaseError: if the knowledge base does not know the plan's facts any more."""
        with self._lock:
            net = self._known.get(plan_id)
        if net is None:
            body = PlanBody.model_validate(session.get_one(PlanRow, plan_id).body)
            net = body.to_plan_net(self._knowledge_base)
        with self._lock:
            self._known[plan_id] = net
            self._known.move_to_end(plan_id)
            if len(self._known) > REMEMBERED:
                self._known.popitem(last=False)
        return net
