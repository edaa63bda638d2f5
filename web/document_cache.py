"""A cache of documents of the service that do not change: plans, recordings."""

import threading
from collections.abc import Callable, Collection
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Generic, TypeVar

T = TypeVar("T")


class DocumentCache(Generic[T]):
    """Documents by name, requested in a background thread; after an error, the next `get` requests again."""

    def __init__(self, fetch: Callable[[str], T], *, retry_s: float = 2.0) -> None:
        self._fetch = fetch
        self._retry_s = retry_s
        self._requests: dict[str, Future[T]] = {}
        self._stopped = threading.Event()
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="fetch")

    def get(self, name: str) -> T | None:
        """The document, or None until it has arrived."""
        if name not in self._requests:
            self._requests[name] = self._pool.submit(self._request, name)
        request = self._requests[name]
        if not request.done():
            return None
        if request.exception() is not None:
            del self._requests[name]
            return None
        return request.result()

    def keep(self, names: Collection[str]) -> None:
        """Drop all documents but these."""
        for name in self._requests.keys() - set(names):
            self._requests.pop(name).cancel()

    def stop(self) -> None:
        self._stopped.set()
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _request(self, name: str) -> T:
        try:
            return self._fetch(name)
        except Exception:
            self._stopped.wait(self._retry_s)  # delays the next request
            raise
