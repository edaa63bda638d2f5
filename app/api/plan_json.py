"""The API's JSON of plans, and pages of JSON.

A stored plan never changes except for the decision on it. Its large part is read, validated and serialised once.
"""

from collections import OrderedDict
from collections.abc import Iterable, Mapping
from threading import Lock
from typing import Any

from fastapi import Response
from pydantic_core import to_json

from app.api.bodies import decision_on, plan_body
from app.store import PlanRow

CACHE_BYTES = 16_000_000
"""About a thousand plans of four actions."""
OVERTAKEN = "overtaken"
JSON = "application/json"


class PlanJson:
    """A cache of the most recently used plans' unchanging parts, as JSON. Thread-safe."""

    def __init__(self, capacity_bytes: int = CACHE_BYTES) -> None:
        self._capacity_bytes = capacity_bytes
        self._lock = Lock()
        self._known: OrderedDict[str, bytes] = OrderedDict()
        self._size_bytes = 0

    def known(self) -> Mapping[str, bytes]:
        """The unchanging parts that are known now, by plan."""
        with self._lock:
            return dict(self._known)

    def of(self, row: PlanRow, known: Mapping[str, bytes], overtaken: Iterable[str] = ()) -> bytes:
        """The JSON of a plan.

        :param known: as `known` returned it; the row needs no body if the plan is in it.
        """
        fixed = known.get(row.id) or self._fixed(row)
        with self._lock:
            if row.id not in self._known:
                self._size_bytes += len(fixed)
            self._known[row.id] = fixed
            self._known.move_to_end(row.id)
            while self._size_bytes > self._capacity_bytes:
                self._size_bytes -= len(self._known.popitem(last=False)[1])
        return fixed[:-1] + b"," + to_json({**decision_on(row), OVERTAKEN: list(overtaken)})[1:]

    def _fixed(self, row: PlanRow) -> bytes:
        return plan_body(row).model_dump_json(exclude={*decision_on(row), OVERTAKEN}).encode()


def json_of(document: Mapping[str, Any]) -> bytes:
    """The document as pydantic's models are serialised."""
    return to_json(document, inf_nan_mode="null")


def json_page(items: Iterable[bytes], token: str | None) -> Response:
    """A response in the form of `Page`."""
    return Response(b'{"items":[' + b",".join(items) + b'],"next":' + to_json(token) + b"}", media_type=JSON)
