"""Plan-nets read from the database, with a cache: a plan never changes once it is stored."""

from collections import OrderedDict
from threading import Lock

from sqlalchemy.orm import Session

from app.domain.plan_document import PlanBody
from app.store import PlanRow
from planner import KnowledgeBase, PlanNet

CACHE_SIZE = 200


class PlanNets:
    """A cache of the most recently used plan-nets. Thread-safe."""

    def __init__(self, knowledge_base: KnowledgeBase) -> None:
        self._knowledge_base = knowledge_base
        self._lock = Lock()
        self._known: OrderedDict[str, PlanNet] = OrderedDict()

    def of(self, session: Session, plan_id: str) -> PlanNet:
        """:raises planner.KnowledgeBaseError: if the plan's facts are no longer in the vocabulary."""
        with self._lock:
            net = self._known.get(plan_id)
        if net is None:
            body = PlanBody.model_validate(session.get_one(PlanRow, plan_id).body)
            net = body.to_plan_net(self._knowledge_base)
        self.keep(plan_id, net)
        return net

    def keep(self, plan_id: str, net: PlanNet) -> None:
        """Have `of` return this plan-net: of a plan that is just being stored, and is about to be read."""
        with self._lock:
            self._known[plan_id] = net
            self._known.move_to_end(plan_id)
            if len(self._known) > CACHE_SIZE:
                self._known.popitem(last=False)
