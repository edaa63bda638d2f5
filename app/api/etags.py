"""Versions as ETags: a change may name the version it was made from; an answer is serialised once for each version."""

from collections.abc import Callable
from typing import Annotated

from fastapi import Header, Response

from app.api.bodies import FactsBody, NumbersBody
from app.api.plan_json import JSON

ANY = "*"
IfMatch = Annotated[
    str | None,
    Header(
        pattern=r'^(\*|(W/)?"[0-9]{1,18}"|[0-9]{1,18})$',
        description='the version that the change was made from: the ETag of GET, `"7"`; `*` is any',
    ),
]


def etag_of(version: int) -> str:
    return f'"{version}"'


def version_of(if_match: str | None) -> int | None:
    """The version that the header names; None if any will do."""
    if if_match is None or if_match == ANY:
        return None
    return int(if_match.removeprefix("W/").strip('"'))


class VersionedJson:
    """The newest answer about each world: serialised once for each version of what it shows."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[str, bytes]] = {}
        """By world: the version's ETag and the answer."""

    def answer(self, world_id: str, version: int, read: Callable[[], FactsBody | NumbersBody]) -> Response:
        """:param version: the present one; the known answer is given again if it is of this version."""
        known = self._known.get(world_id)
        if known is None or known[0] != etag_of(version):
            body = read()
            known = self._known[world_id] = (etag_of(body.version), body.model_dump_json().encode())
        return Response(known[1], media_type=JSON, headers={"etag": known[0]})
