"""The view of the worlds in three dimensions, a process of its own.

`python -m web.viewer --api URL --port P`. A client of the public API like any other, with the token from
MACTA_TOKEN; it listens on loopback only. Every page sees what it shows itself: its world, its selection, its camera.
"""

import argparse
import logging
import os
import signal
import threading
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from types import FrameType
from typing import Any

import httpx2
import viser

from web.api_types import Layout, Plan, Shown
from web.document_cache import Fetched
from web.live_world import LiveWorld
from web.page_feed import PagesFeed
from web.recording import Recording
from web.scene import Frame, Stage
from web.world_feed import WorldFeed

UPDATE_EVERY_S = 0.05
NAMES_EVERY = 6
"""Updates after which it is decided anew which labels have room."""


class Viewer:
    """Draws in every connected browser what its page shows, at most 20 times a second."""

    def __init__(
        self,
        *,
        api: str,
        token: str,
        port: int,
        stopped: threading.Event | None = None,
        facts_every_s: float = 1.0,
        again_s: float = 1.0,
    ) -> None:
        self._stopped = stopped or threading.Event()
        self._pages = PagesFeed(api=api, token=token, again_s=again_s)
        self._client = httpx2.Client(
            base_url=api, headers={"authorization": f"Bearer {token}"}, timeout=10.0, trust_env=False
        )
        self._feed = partial(WorldFeed, api=api, token=token, facts_every_s=facts_every_s, again_s=again_s)
        self._worlds: dict[str, LiveWorld] = {}
        self._first = Fetched(lambda _: str(self._ask("/v1/worlds")["items"][0]["id"]), again_s=again_s)
        self._plans = Fetched(lambda id_: Plan.model_validate(self._ask(f"/v1/plans/{id_}")), again_s=again_s)
        self._recordings = Fetched(
            lambda id_: Recording.model_validate(self._ask(f"/v1/missions/{id_}/replay")), again_s=again_s
        )
        self.stages: dict[int, Stage] = {}
        """By the browser's client id."""
        self._drawn: dict[int, tuple[Frame, Shown, Plan | None]] = {}
        self.server = viser.ViserServer(host="127.0.0.1", port=port, label="Macta", verbose=False)
        self._updates = 0
        self._set_stage()

    def run(self, as_long_as: Callable[[], bool] = lambda: True) -> None:
        """Follow the service until `stop`, and only `as_long_as` holds."""
        self._pages.start()
        while not self._stopped.wait(UPDATE_EVERY_S) and as_long_as():
            self.draw()
        for world in self._worlds.values():
            world.stop()
        for fetched in (self._first, self._plans, self._recordings):
            fetched.stop()
        self._pages.stop()
        self._client.close()
        self.server.stop()

    def stop(self) -> None:
        self._stopped.set()

    def draw(self) -> None:
        """Bring every browser's scene up to date."""
        clients, pages = self.server.get_clients(), self._pages.pages()
        self.stages = {id_: stage for id_, stage in self.stages.items() if id_ in clients}
        self._drawn = {id_: drawn for id_, drawn in self._drawn.items() if id_ in clients}
        shown = {id_: _shown(self.server, id_, pages) for id_ in clients}
        self._follow_worlds({one.world or self._first.get("") for one in shown.values() if one is not None})
        for id_, client in clients.items():
            one = shown[id_]
            if one is not None:
                # A browser that goes in the middle of it is not there the next time.
                with suppress(RuntimeError):
                    self._draw_for(id_, client, one)
        self._updates += 1
        showing = [one for one in shown.values() if one is not None]
        self._plans.keep({one.plan_id for one in showing if one.plan_id})
        self._recordings.keep({one.replay.mission_id for one in showing if one.replay})

    def _draw_for(self, id_: int, client: viser.ClientHandle, shown: Shown) -> None:
        layout, frame = self._instant(shown)
        if layout is None:
            return
        stage = self.stages.get(id_)
        if stage is None or (stage.layout, stage.dark) != (layout, shown.dark):
            client.scene.reset()
            stage = self.stages[id_] = Stage(client, layout, self._picker(id_), dark=shown.dark)
        drawing = (frame, shown, self._plans.get(shown.plan_id) if shown.plan_id else None)
        if self._drawn.get(id_) is None or any(
            new is not old for new, old in zip(drawing, self._drawn[id_], strict=True)
        ):
            self._drawn[id_] = drawing
            stage.update(*drawing)
        if self._updates % NAMES_EVERY == id_ % NAMES_EVERY:
            stage.name()

    def _instant(self, shown: Shown) -> tuple[Layout | None, Frame]:
        """The world as the page shows it: an instant of a recording, or now."""
        if shown.replay is not None:
            recording = self._recordings.get(shown.replay.mission_id)
            if recording is not None:
                return recording.world.layout, recording.at(shown.replay.time_s)
        world = self._worlds.get(shown.world or self._first.get("") or "")
        return (None, Frame()) if world is None else (world.layout, world.frame)

    def _follow_worlds(self, names: set[str | None]) -> None:
        """Follow the worlds that somebody looks at, and no others."""
        for left in self._worlds.keys() - names:
            self._worlds.pop(left).stop()
        for name in names:
            if name is not None and name not in self._worlds:
                self._worlds[name] = LiveWorld(self._feed(world=name))
        for world in self._worlds.values():
            world.look()

    def _picker(self, client_id: int) -> Callable[[str, str], None]:
        page = page_of(self.server, client_id)
        return lambda kind, name: self._pages.pick(page, kind, name) if page else None

    def _ask(self, path: str) -> dict[str, Any]:
        answer = self._client.get(path)
        answer.raise_for_status()
        body: dict[str, Any] = answer.json()
        return body

    def _set_stage(self) -> None:
        scene, gui = self.server.scene, self.server.gui
        scene.set_up_direction("+z")
        # NOTE: an environment map or cast shadows stall a browser without graphics hardware for seconds.
        scene.configure_environment_map(None)
        scene.configure_default_lights(enabled=False, cast_shadow=False)
        scene.add_light_ambient("/lights/ambient", intensity=1.7)
        scene.add_light_directional(
            "/lights/sun", intensity=1.5, position=(-4.0, -7.0, 10.0), cast_shadow=False
        )
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="small")
        gui.main_panel.minimize()


def page_of(server: viser.ViserServer, client_id: int) -> str:
    """The id under which the browser's page shows what it shows, empty if it is nobody's frame.

    It is the path that the browser asked for its socket at; viser keeps the connection but hands out no word of it.
    """
    connection = server._websock_server._live_connections.get(client_id)
    path = "" if connection is None or connection.request is None else connection.request.path
    return path.partition("?")[0].strip("/")


def _shown(server: viser.ViserServer, client_id: int, pages: Mapping[str, Shown]) -> Shown | None:
    """What to draw in this browser; None if its page has not said, or nobody sees it.

    The first world if it has no page.
    """
    page = page_of(server, client_id)
    told = pages.get(page) if page else Shown()
    return told if told is not None and told.seen else None


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the view until SIGTERM or SIGINT, or until the process that started it is gone."""
    parser = argparse.ArgumentParser(prog="python -m web.viewer", description="Macta's view of its worlds")
    parser.add_argument("--api", required=True, help="the service's address, e.g. http://127.0.0.1:8000")
    parser.add_argument("--port", required=True, type=int, help="the loopback port to serve the view on")
    # Given, not asked for here: by the time this runs the parent may be gone already.
    parser.add_argument("--parent", type=int, default=os.getppid(), help="the process to end with")
    options = parser.parse_args(arguments)
    stopped = threading.Event()
    # Whoever asks whether the view is there connects and says nothing, which is no error worth a traceback.
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL)
    # Nor is a browser that leaves while it is drawn for.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)

    def stop(_signal: int, _frame: FrameType | None) -> None:
        stopped.set()

    # Before the server starts: a signal may come as soon as its page can be fetched.
    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, stop)
    Viewer(api=options.api, token=os.environ.get("MACTA_TOKEN", ""), port=options.port, stopped=stopped).run(
        as_long_as=lambda: os.getppid() == options.parent
    )


if __name__ == "__main__":
    main()
