"""The view of the worlds in three dimensions, a process of its own.

`python -m web.viewer --api URL --port P`. It is a client of the public API, with the token from MACTA_TOKEN; it listens
on loopback only, and answers only clients with the secret from MACTA_VIEWER_SECRET. Every page has its own world,
selection and camera.
"""

import argparse
import logging
import os
import signal
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from types import FrameType
from typing import Any

import httpx2
import viser

from web.api_types import Layout, PageState, Plan
from web.document_cache import DocumentCache
from web.live_world import LiveWorld
from web.page_feed import PageFeed
from web.recording import Recording
from web.scene import Frame, PageScene
from web.viser_private import guarded_server, ignore_closed_connections, request_path
from web.world_feed import WorldFeed

UPDATE_EVERY_S = 0.05
UPDATES_PER_LABEL_LAYOUT = 6
END_UNUSED_S = 60.0
"""The process ends when no browser has been connected, and none has requested anything, for this long."""
DEFAULT_WORLD = ""
"""Stands for the first world, which is shown to a browser that belongs to no page."""


class Viewer:
    """Draws in every connected browser what its page shows, at most 20 times a second."""

    def __init__(
        self,
        *,
        api: str,
        token: str,
        port: int,
        secret: str,
        stopped: threading.Event | None = None,
        facts_every_s: float = 1.0,
        retry_s: float = 1.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.pages = PageFeed(api=api, token=token, retry_s=retry_s)
        self._clock = clock
        self._used_at_s = clock()
        self.server = guarded_server(port=port, secret=secret, on_request=self._note_use)
        self.scenes: dict[int, PageScene] = {}
        """By the browser's client id."""
        self.worlds: dict[str, LiveWorld] = {}
        """The worlds that some page shows."""
        self.updates = 0
        """Counts the calls of `draw`."""
        self._stopped = stopped or threading.Event()
        self._client = httpx2.Client(
            base_url=api, headers={"authorization": f"Bearer {token}"}, timeout=10.0, trust_env=False
        )
        self._feed = partial(WorldFeed, api=api, token=token, facts_every_s=facts_every_s, retry_s=retry_s)
        self._default_world = DocumentCache(
            lambda _: str(self._get("/v1/worlds")["items"][0]["id"]), retry_s=retry_s
        )
        self._plans = DocumentCache(
            lambda id_: Plan.model_validate(self._get(f"/v1/plans/{id_}")), retry_s=retry_s
        )
        self._recordings = DocumentCache(
            lambda id_: Recording.model_validate(self._get(f"/v1/missions/{id_}/replay")), retry_s=retry_s
        )
        self._drawn: dict[int, tuple[Frame, PageState, Plan | None]] = {}
        self._set_up_scene()

    def run(self, as_long_as: Callable[[], bool] = lambda: True) -> None:
        """Follow the service until `stop`, and only while `as_long_as` holds."""
        self.pages.start()
        due_s = self._clock()
        while not self._stopped.wait(max(0.0, due_s - self._clock())) and as_long_as():
            self.draw()
            due_s = max(due_s + UPDATE_EVERY_S, self._clock())  # a late update is not caught up with
        for world in self.worlds.values():
            world.stop()
        for cache in (self._default_world, self._plans, self._recordings):
            cache.stop()
        self.pages.stop()
        self._client.close()
        self.server.stop()

    def stop(self) -> None:
        self._stopped.set()

    @property
    def unused_s(self) -> float:
        """How long no browser has been connected, nor has requested anything."""
        return self._clock() - self._used_at_s

    def _note_use(self) -> None:
        self._used_at_s = self._clock()

    def draw(self) -> None:
        """Update every browser's scene."""
        clients = self.server.get_clients()
        if clients:
            self._note_use()
        self.scenes = {id_: scene for id_, scene in self.scenes.items() if id_ in clients}
        self._drawn = {id_: drawn for id_, drawn in self._drawn.items() if id_ in clients}
        states = self._visible_states(clients)
        self._follow_worlds({self._world_of(state) for state in states.values()})
        for id_, state in states.items():
            with suppress(RuntimeError):  # the browser has disconnected
                self._draw_for(id_, clients[id_], state)
        self.updates += 1
        self._plans.keep({state.plan_id for state in states.values() if state.plan_id})
        self._recordings.keep({state.replay.mission_id for state in states.values() if state.replay})

    def _visible_states(self, clients: Mapping[int, viser.ClientHandle]) -> dict[int, PageState]:
        """The states of the browsers' pages, without those that have not sent one or are not visible."""
        pages = self.pages.states()
        states = {}
        for id_ in clients:
            page = page_of(self.server, id_)
            state = pages.get(page) if page else PageState()
            if state is not None and state.seen:
                states[id_] = state
        return states

    def _draw_for(self, id_: int, client: viser.ClientHandle, state: PageState) -> None:
        layout, frame = self._instant(state)
        if layout is None:
            return
        scene = self.scenes.get(id_)
        if scene is None or (scene.layout, scene.dark) != (layout, state.dark):
            client.scene.reset()
            scene = PageScene(client, layout, self._pick_sender(id_), dark=state.dark)
            self.scenes[id_] = scene
        drawing = (frame, state, self._plans.get(state.plan_id) if state.plan_id else None)
        last = self._drawn.get(id_)
        if last is None or any(new is not old for new, old in zip(drawing, last, strict=True)):
            self._drawn[id_] = drawing
            scene.update(*drawing)
        if self.updates % UPDATES_PER_LABEL_LAYOUT == id_ % UPDATES_PER_LABEL_LAYOUT:
            scene.lay_out_labels()

    def _instant(self, state: PageState) -> tuple[Layout | None, Frame]:
        """The world as the page shows it: an instant of a recording, or now."""
        if state.replay is not None:
            recording = self._recordings.get(state.replay.mission_id)
            if recording is not None:
                return recording.world.layout, recording.at(state.replay.time_s)
        world = self.worlds.get(self._world_of(state) or "")
        return (None, Frame()) if world is None else (world.layout, world.frame)

    def _world_of(self, state: PageState) -> str | None:
        return state.world or self._default_world.get(DEFAULT_WORLD)

    def _follow_worlds(self, names: set[str | None]) -> None:
        for unused in self.worlds.keys() - names:
            self.worlds.pop(unused).stop()
        for name in names:
            if name is not None and name not in self.worlds:
                self.worlds[name] = LiveWorld(self._feed(world=name))
        for world in self.worlds.values():
            world.update()

    def _pick_sender(self, client_id: int) -> Callable[[str, str], None]:
        page = page_of(self.server, client_id)
        return lambda kind, name: self.pages.send_pick(page, kind, name) if page else None

    def _get(self, path: str) -> dict[str, Any]:
        response = self._client.get(path)
        response.raise_for_status()
        body: dict[str, Any] = response.json()
        return body

    def _set_up_scene(self) -> None:
        scene = self.server.scene
        scene.set_up_direction("+z")
        # NOTE: an environment map or cast shadows stall a browser without graphics hardware for seconds.
        scene.configure_environment_map(None)
        scene.configure_default_lights(enabled=False, cast_shadow=False)
        scene.add_light_ambient("/lights/ambient", intensity=1.7)
        scene.add_light_directional(
            "/lights/sun", intensity=1.5, position=(-4.0, -7.0, 10.0), cast_shadow=False
        )
        self.server.gui.configure_theme(show_logo=False, show_share_button=False, control_width="small")
        self.server.gui.main_panel.minimize()


def page_of(server: viser.ViserServer, client_id: int) -> str:
    """The id of the page that embeds the browser's frame, from the frame's address; empty without one."""
    return request_path(server, client_id).partition("?")[0].strip("/")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the view until SIGTERM or SIGINT, the end of the parent process, or a minute in which nobody uses it."""
    parser = argparse.ArgumentParser(prog="python -m web.viewer", description="Macta's view of its worlds")
    parser.add_argument("--api", required=True, help="address of the service, e.g. http://127.0.0.1:8000")
    parser.add_argument("--port", required=True, type=int, help="loopback port to serve the view on")
    # An option, because the parent may end before this process can query its id.
    parser.add_argument("--parent", type=int, default=os.getppid(), help="process to end with")
    options = parser.parse_args(arguments)
    secret = os.environ.get("MACTA_VIEWER_SECRET")
    if not secret:
        parser.error("set MACTA_VIEWER_SECRET: the password that the service sends")
    stopped = threading.Event()
    # Health checks connect without a request, which websockets logs with a traceback.
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL)
    ignore_closed_connections()

    def stop(_signal: int, _frame: FrameType | None) -> None:
        stopped.set()

    # Before the server starts: a signal may arrive as soon as its page can be fetched.
    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, stop)
    viewer = Viewer(
        api=options.api,
        token=os.environ.get("MACTA_TOKEN", ""),
        port=options.port,
        secret=secret,
        stopped=stopped,
    )
    viewer.run(lambda: os.getppid() == options.parent and viewer.unused_s < END_UNUSED_S)


if __name__ == "__main__":
    main()
