"""Versions as ETags: a change may name the version it was made from."""

from typing import Annotated

from fastapi import Header

from app.domain.errors import Invalid

IfMatch = Annotated[str | None, Header(description="the version the change was made from")]


def version_of(if_match: str | None, what: str) -> int | None:
    """The version that the header names; None if it is not there.

    :raises Invalid: if it is no version of the thing.
    """
    if if_match is None:
        return None
    tag = if_match.strip().removeprefix("W/").strip('"')
    if not tag.isdigit():
        raise Invalid(
            f"If-Match: {if_match!r} is no version of {what}; use the ETag of GET", code="bad-if-match"
        )
    return int(tag)
