"""Requests of commands to a running service; refusals are errors in the service's own words."""

from collections.abc import Iterator
from contextlib import contextmanager
from os import environ
from typing import TYPE_CHECKING, Any

from app.domain.errors import Invalid

if TYPE_CHECKING:
    from httpx2 import Client, Response


@contextmanager
def connected(service: str) -> Iterator["Client"]:
    """A client of the service at this address, with the token of MACTA_TOKEN."""
    from httpx2 import Client

    token = environ.get("MACTA_TOKEN", "")
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    with Client(base_url=service, headers=headers, timeout=10.0) as client:
        yield client


def answer_of(service: "Client", verb: str, path: str, body: object = None) -> Any:
    """What the service answers to the request.

    :raises Invalid: if it refuses, with its reason, or there is none.
    """
    from httpx2 import HTTPError

    try:
        response = service.request(verb, path, json=body)
    except HTTPError as error:
        raise Invalid(f"no service answers at {service.base_url}: {error}; state --service") from error
    if response.status_code == 401:
        raise Invalid(f"{service.base_url} does not know the token; set MACTA_TOKEN to the service's token")
    if response.is_error:
        raise Invalid(_refusal(response))
    return response.json()


def _refusal(response: "Response") -> str:
    try:
        problem = response.json()
    except ValueError:
        return f"{response.request.url} answers {response.status_code}, which is no answer of Macta"
    detail = problem.get("detail") or problem.get("title") or str(response.status_code)
    return str(detail).removeprefix("edits.0: ")
