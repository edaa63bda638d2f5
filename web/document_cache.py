"""Documents that the service is asked for by name and that stay as they are: plans, recordings."""

import threading
from collections.abc import Callable, Collection
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Generic, TypeVar

T = TypeVar("T")


class Fetched(Generic[T]):
    """What was fetched, by name; asked for in the background, and anew a while after that has failed."""

    def __init__(self, fetch: Callable[[str], T], *, again_s: float = 2.0) -> None:
        self._fetch, self._again_s = fetch, again_s
        self._known: dict[str, Future[T]] = {}
        self._stopped = threading.Event()
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="fetch")

    def get(self, name: str) -> T | None:
        """The document, None as long as it is not there."""
        if name not in self._known:
            self._known[name] = self._pool.submit(self._ask, name)
        asked = self._known[name]
        if not asked.done():
            return None
        if asked.exception() is not None:
            del self._known[name]
            return None
        return asked.result()

    def keep(self, names: Collection[str]) -> None:
        """Forget all but these."""
        for name in self._known.keys() - set(names):
            self._known.pop(name).cancel()

    def stop(self) -> None:
        self._stopped.set()
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _ask(self, name: str) -> T:
        try:
            return self._fetch(name)
        except Exception:
            self._stopped.wait(self._again_s)  # whoever asks again meanwhile waits for this
            raise
