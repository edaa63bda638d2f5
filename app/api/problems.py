"""Errors as problem details (RFC 9457)."""

import logging
import re
from collections.abc import Sequence
from typing import Any
from urllib.parse import quote

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from fastapi.routing import APIRoute
from pydantic import BaseModel, ConfigDict, Field
from sqlalchemy.exc import DBAPIError, SQLAlchemyError
from starlette.exceptions import HTTPException

from app.api.problem_body import PROBLEM, problem_body
from app.domain.errors import Busy, Conflict, Invalid, MactaError, NotFound, Outdated, Silent, Unavailable
from app.store import is_unavailable, is_unwritable

STATUS: dict[type[MactaError], int] = {
    Invalid: 422,
    NotFound: 404,
    Conflict: 409,
    Outdated: 412,
    Busy: 429,
    Unavailable: 503,
    Silent: 504,
}
RETRY_AFTER_S = 2
MEANING: dict[int, str] = {
    400: "The body cannot be read.",
    401: "The token is missing or wrong.",
    404: "The request names something that does not exist; `choices` lists what does.",
    409: "The request contradicts the present state.",
    412: "The resource has changed since the version in `If-Match`.",
    413: "The body is too large.",
    422: "The request can never be carried out as it is; `errors` or `choices` say why.",
    429: "Too many goals, streams or questions are open; `Retry-After` says when to ask again.",
    503: "The service cannot answer now; try again later.",
    504: "The robot did not answer in time.",
}


Misfit = tuple[str, str]
"""A part of the request, and what is wrong with it."""


class MalformedSlot(BaseModel):
    """A part of the request that does not fit the schema."""

    slot: str
    message: str


class Problem(BaseModel):
    """An error (RFC 9457). Some codes add members of their own."""

    model_config = ConfigDict(extra="allow")

    type: str = Field(description="a stable code, `urn:macta:problem:CODE`")
    title: str
    status: int
    detail: str = Field(description="names the thing that is wrong")
    choices: list[str] | None = Field(default=None, description="what would work")
    constraints: list[str] | None = Field(
        default=None,
        description="the smallest set of constraints that cannot be kept together, each in words",
    )
    thing: str | None = Field(default=None, description="the word or name that it is about")
    span: tuple[int, int] | None = Field(
        default=None, description="where in the sentence that word is, start and end; or where it is missing"
    )
    errors: list[MalformedSlot] | None = Field(default=None, description="what does not fit the schema")


def declared(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """The `responses` of a route that may answer these problems."""
    schema = {"$ref": f"#/components/schemas/{Problem.__name__}"}
    return {
        status: {"description": MEANING[status], "content": {PROBLEM: {"schema": schema}}}
        for status in sorted(statuses)
    }


def problem(status: int, code: str, detail: str, choices: Sequence[str] = (), **more: Any) -> JSONResponse:
    """A response with that problem body."""
    return JSONResponse(problem_body(status, code, detail, choices, **more), status, media_type=PROBLEM)


def malformed(misfits: Sequence[Misfit]) -> JSONResponse:
    """The response to a request that does not fit the schema."""
    detail = "; ".join(f"{slot}: {message}" for slot, message in misfits)
    errors = [{"slot": slot, "message": message} for slot, message in misfits]
    return problem(422, "malformed-request", detail, errors=errors)


def install(app: FastAPI) -> None:
    """Make the app answer every error with a problem."""
    app.add_exception_handler(MactaError, _domain)
    app.add_exception_handler(RequestValidationError, _malformed)
    app.add_exception_handler(HTTPException, _http)
    app.add_exception_handler(SQLAlchemyError, _database)
    app.add_exception_handler(Exception, _internal)


async def _domain(_: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, MactaError)
    about: dict[str, Any] = {"thing": error.thing} if error.thing else {}
    if error.constraints:
        about["constraints"] = list(error.constraints)
    if error.span is not None:
        about["span"] = list(error.span)
    status = next((STATUS[kind] for kind in type(error).__mro__ if kind in STATUS), 400)
    answer = problem(status, error.code, error.detail, error.choices, **about)
    if error.retry_after_s is not None:
        answer.headers["retry-after"] = f"{error.retry_after_s:.0f}"
    return answer


async def _malformed(_: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)
    return malformed([(".".join(str(part) for part in e["loc"]), e["msg"]) for e in error.errors()])


async def _http(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)
    allowed = _allowed(request) if error.status_code in (404, 405) else set()
    if allowed and request.method not in allowed:
        # Also if the mount of the console's files, which is matched after all routes, answered 404.
        answer = problem(405, "method-not-allowed", f"{_where(request)}: Method Not Allowed")
        answer.headers["allow"] = ", ".join(sorted(allowed))
        return answer
    code = {404: "not-found", 405: "method-not-allowed"}.get(error.status_code, "http-error")
    answer = problem(error.status_code, code, f"{_where(request)}: {error.detail}")
    answer.headers.update(error.headers or {})
    return answer


async def _database(request: Request, error: Exception) -> JSONResponse:
    """The database is unavailable or another transaction conflicted; a later request may succeed."""
    if not is_unavailable(error):
        return await _internal(request, error)
    if isinstance(error, DBAPIError) and is_unwritable(error):
        detail = f"the database cannot be written: {error.orig}; nothing was changed"
        logging.getLogger(__name__).error("%s", detail)
        answer = problem(503, "record-not-writable", detail)
    else:
        answer = problem(503, "database-away", "the database does not answer; try again in a moment")
    answer.headers["retry-after"] = str(RETRY_AFTER_S)
    return answer


async def _internal(request: Request, error: Exception) -> JSONResponse:
    """An unexpected error. Its text is only logged: it may contain secrets."""
    where = _where(request)
    logging.getLogger(__name__).error("%s failed", where, exc_info=error)
    return problem(500, "internal", f"{where}: the service failed; its log says why")


def _where(request: Request) -> str:
    """Method and path; quoted, so that a line feed in a path cannot forge a line of the log."""
    return f"{request.method} {quote(request.scope['path'])}"


def _allowed(request: Request) -> set[str]:
    """The methods of all documented API routes that match the path; empty if none does."""
    return {
        method
        for route in request.app.routes
        if isinstance(route, APIRoute) and route.include_in_schema
        if re.fullmatch(re.sub(r"\\{\w+\\}", "[^/:]+", re.escape(route.path_format)), request.scope["path"])
        for method in route.methods or ()
    }
