"""Versions as ETags: a change may name the version it was made from."""

from typing import Annotated

from fastapi import Header

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
