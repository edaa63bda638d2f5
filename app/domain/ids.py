"""Ids: a kind and twelve random hex digits, e.g. `goal-3f9a…`."""

import uuid


def new_id(kind: str) -> str:
    return f"{kind}-{uuid.uuid4().hex[:12]}"
