"""What each open page shows, heard from the service, and word to a page of what was picked in its view."""

import json
import threading
from collections.abc import Mapping

from pydantic import ValidationError
from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect

from web.api_types import Part, Shown


class Changed(Part):
    id: str
    shown: Shown | None = None


class PagesFeed:
    """The open pages, by the id each has given itself; followed by a thread until `stop`."""

    def __init__(self, *, api: str, token: str, again_s: float = 1.0) -> None:
        self._address = f"{api.replace('http', 'ws', 1)}/v1/views"
        self._headers = {"authorization": f"Bearer {token}"}
        self._again_s = again_s
        self._pages: dict[str, Shown] = {}
        self._socket: ClientConnection | None = None
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._follow, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._stopped.set()
        if self._socket is not None:
            self._socket.close()

    def pages(self) -> Mapping[str, Shown]:
        """What each page shows now."""
        return dict(self._pages)

    def pick(self, page: str, kind: str, name: str) -> None:
        """Tell the page; a service that is away for the moment is not told, nor is it told later."""
        if self._socket is None:
            return
        try:
            self._socket.send(json.dumps({"id": page, "pick": {"kind": kind, "name": name}}))
        except WebSocketException:
            return

    def _follow(self) -> None:
        while not self._stopped.is_set():
            try:
                socket = connect(self._address, additional_headers=self._headers, proxy=None)
                with socket:
                    self._socket = socket
                    self._pages.clear()
                    for text in socket:
                        self._learn(text)
            except (OSError, WebSocketException, ValidationError, TimeoutError):
                pass  # tried again, as long as it takes
            self._socket = None
            self._stopped.wait(self._again_s)

    def _learn(self, text: str | bytes) -> None:
        changed = Changed.model_validate_json(text)
        if changed.shown is None:
            self._pages.pop(changed.id, None)
        else:
            self._pages[changed.id] = changed.shown
