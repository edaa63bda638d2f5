"""Parameters that several routes take."""

from typing import Annotated

from fastapi import Header, Path, Query
from pydantic import Field

MAX_NAME_LENGTH = 120
"""Maximum length of ids and names: the width of the database's columns."""

Name = Annotated[str, Field(min_length=1, max_length=MAX_NAME_LENGTH)]
"""An id or a name in a body."""
Id = Annotated[str, Path(min_length=1, max_length=MAX_NAME_LENGTH)]
NameFilter = Annotated[str | None, Query(min_length=1, max_length=MAX_NAME_LENGTH)]
Limit = Annotated[int, Query(ge=1, le=1000)]
After = Annotated[
    str | None, Query(max_length=200, pattern="^[^~]+~[^~]+$", description="`next` of the page before")
]
IdempotencyKey = Annotated[
    str | None,
    Header(
        min_length=1,
        max_length=200,
        pattern="^[ -~]+$",
        description="requests with the same key submit one goal: repeat a request with its key",
    ),
]
