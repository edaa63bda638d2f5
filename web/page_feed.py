"""The states of the open pages, received from the service, and picks sent to the pages."""

import json
import threading
from collections.abc import Mapping

from pydantic import ValidationError
from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect

from web.api_types import ApiModel, PageState


class PageChange(ApiModel):
    """A page's new state; None when it was closed."""

    id: str
    shown: PageState | None = None


class PageFeed:
    """The open pages by their ids, received in a thread until `stop`."""

    def __init__(self, *, api: str, token: str, retry_s: float = 1.0) -> None:
        self._address = f"{api.replace('http', 'ws', 1)}/v1/views"
        self._headers = {"authorization": f"Bearer {token}"}
        self._retry_s = retry_s
        self._states: dict[str, PageState] = {}
        self._socket: ClientConnection | None = None
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._follow, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._stopped.set()
        if self._socket is not None:
            self._socket.close()

    def states(self) -> Mapping[str, PageState]:
        """The state of each open page."""
        return dict(self._states)

    def send_pick(self, page: str, kind: str, name: str) -> None:
        """Send a pick to the page; it is lost while the service is unavailable."""
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
                    self._states.clear()
                    for text in socket:
                        self._receive(text)
            except (OSError, WebSocketException, ValidationError, TimeoutError):
                pass  # connect again
            self._socket = None
            self._stopped.wait(self._retry_s)

    def _receive(self, text: str | bytes) -> None:
        change = PageChange.model_validate_json(text)
        if change.shown is None:
            self._states.pop(change.id, None)
        else:
            self._states[change.id] = change.shown
