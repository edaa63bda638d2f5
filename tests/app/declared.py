"""Checks that every error the API answers is declared in its OpenAPI document."""

import re
from collections.abc import Callable
from typing import Any

import httpx2
from fastapi import FastAPI

_paths: dict[str, Any] = {}
"""Of the document, which is made once for all tests: it is the same for every service."""


def declared_errors(api: FastAPI) -> Callable[[httpx2.Response], None]:
    """A response hook for a client of the API."""

    def check(response: httpx2.Response) -> None:
        if response.status_code < 400 or response.status_code == 500:
            return
        if not _paths:
            _paths.update(api.openapi()["paths"])
        for path, operations in _paths.items():
            pattern = re.sub(r"\\{\w+\\}", "[^/:]*", re.escape(path))
            operation = operations.get(response.request.method.lower())
            if operation and re.fullmatch(pattern, response.request.url.path):
                assert str(response.status_code) in operation["responses"], (path, response.status_code)

    return check
