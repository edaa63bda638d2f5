"""The API's JSON of plans, and pages of JSON.

A stored plan never changes except for the decision on it, and the chances of its deadlines as time goes by. Its large
part is read, validated and serialised once.
"""

from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from threading import Lock
from typing import Any

from fastapi import Response
from pydantic_core import to_json

from app.api.bodies import decision_on, plan_body
from app.domain.plan_document import ForecastBody
from app.store import PlanRow

CACHE_BYTES = 16_000_000
"""About a thousand plans of four actions."""
OVERTAKEN = "overtaken"
FORECAST = "forecast"
JSON = "application/json"


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownPlan:
    """A plan's unchanging part as JSON, and its forecast as it was made; None: it has no deadlines to near."""

    fixed: bytes
    forecast: ForecastBody | None

    @property
    def size_bytes(self) -> int:
        return len(self.fixed)


class PlanJson:
    """A cache of the most recently used plans' unchanging parts. Thread-safe."""

    def __init__(self, capacity_bytes: int = CACHE_BYTES) -> None:
        self._capacity_bytes = capacity_bytes
        self._lock = Lock()
        self._known: OrderedDict[str, KnownPlan] = OrderedDict()
        self._size_bytes = 0

    def known(self) -> Mapping[str, KnownPlan]:
        """The unchanging parts that are known now, by plan."""
        with self._lock:
            return dict(self._known)

    def of(
        self,
        row: PlanRow,
        known: Mapping[str, KnownPlan],
        overtaken: Iterable[str] = (),
        *,
        start: Callable[[PlanRow], float | None] = lambda _: None,
    ) -> bytes:
        """The JSON of a plan.

        :param known: as `known` returned it; the row needs no body if the plan is in it.
        :param start: when a plan starts, by the world's clock; None: when it was to.
        """
        plan = known.get(row.id) or _known(row)
        with self._lock:
            if row.id not in self._known:
                self._size_bytes += plan.size_bytes
            self._known[row.id] = plan
            self._known.move_to_end(row.id)
            while self._size_bytes > self._capacity_bytes:
                self._size_bytes -= self._known.popitem(last=False)[1].size_bytes
        changing: dict[str, Any] = {**decision_on(row), OVERTAKEN: list(overtaken)}
        if plan.forecast is not None:
            changing[FORECAST] = plan.forecast.starting_at(start(row)).model_dump(mode="json")
        return plan.fixed[:-1] + b"," + to_json(changing)[1:]


def _known(row: PlanRow) -> KnownPlan:
    body = plan_body(row)
    has_deadline = body.forecast is not None and body.forecast.on_time is not None
    changing = {*decision_on(row), OVERTAKEN, *([FORECAST] if has_deadline else [])}
    fixed = body.model_dump_json(exclude=changing).encode()
    return KnownPlan(fixed=fixed, forecast=body.forecast if has_deadline else None)


def json_of(document: Mapping[str, Any]) -> bytes:
    """The document as pydantic's models are serialised."""
    return to_json(document, inf_nan_mode="null")


def json_page(items: Iterable[bytes], token: str | None) -> Response:
    """A response in the form of `Page`."""
    return Response(b'{"items":[' + b",".join(items) + b'],"next":' + to_json(token) + b"}", media_type=JSON)
