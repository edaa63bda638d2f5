"""The view of a world in three dimensions, a process of its own.

`python -m web.viewer --api URL --port P --world ID`. A client of the public API like any other, with the
token from MACTA_TOKEN; it listens on loopback only.
"""

import argparse
import os
import signal
import threading
from collections.abc import Callable, Sequence
from types import FrameType

import viser

from web.feed import Known, WorldFeed
from web.layout import Layout
from web.scene import RobotsView, SamplesView, aim_camera, draw_store, light_store

UPDATE_EVERY_S = 0.05


class Viewer:
    """Draws what the feed knows, at most 20 times a second."""

    def __init__(self, *, feed: WorldFeed, port: int, stopped: threading.Event | None = None) -> None:
        self._feed = feed
        self._stopped = stopped or threading.Event()
        self.server = viser.ViserServer(host="127.0.0.1", port=port, label="Macta", verbose=False)
        self._layout: Layout | None = None
        self._robots: RobotsView | None = None
        self._samples: SamplesView | None = None
        self._set_stage()

    def run(self, as_long_as: Callable[[], bool] = lambda: True) -> None:
        """Follow the feed until `stop`, and only `as_long_as` holds."""
        self._feed.start()
        drawn = -1
        while not self._stopped.is_set() and as_long_as():
            known = self._feed.latest(after=drawn, timeout_s=0.5)
            if known.version != drawn:
                drawn = known.version
                self.draw(known)
            self._stopped.wait(UPDATE_EVERY_S)
        self._feed.stop()
        self.server.stop()

    def stop(self) -> None:
        self._stopped.set()

    def draw(self, known: Known) -> None:
        """Bring the scene up to date; the building anew only if it is another one."""
        if known.layout is None:
            return
        with self.server.atomic():
            if known.layout != self._layout:
                self._build(known.layout)
            if self._robots is not None:
                self._robots.update(known.telemetry.robots, known.telemetry.time_s)
            if self._samples is not None:
                self._samples.update(known.facts, known.telemetry.robots)

    def _set_stage(self) -> None:
        scene, gui = self.server.scene, self.server.gui
        scene.set_up_direction("+z")
        # NOTE: an environment map or cast shadows stall a browser without graphics hardware for seconds.
        scene.configure_environment_map(None)
        scene.configure_default_lights(enabled=False, cast_shadow=False)
        light_store(self.server)
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="small")
        gui.main_panel.minimize()

    def _build(self, layout: Layout) -> None:
        if self._layout is not None:
            self.server.scene.reset()
            self._set_stage()
        self._layout = layout
        draw_store(self.server, layout)
        aim_camera(self.server, layout)
        self._robots = RobotsView(self.server, [robot.name for robot in layout.robots])
        self._samples = SamplesView(self.server, layout)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the view until SIGTERM or SIGINT, or until the process that started it is gone."""
    parser = argparse.ArgumentParser(prog="python -m web.viewer", description="Macta's view of a world")
    parser.add_argument("--api", required=True, help="the service's address, e.g. http://127.0.0.1:8000")
    parser.add_argument("--port", required=True, type=int, help="the loopback port to serve the view on")
    parser.add_argument("--world", required=True, help="the world's id")
    # Given, not asked for here: by the time this runs the parent may be gone already.
    parser.add_argument("--parent", type=int, default=os.getppid(), help="the process to end with")
    options = parser.parse_args(arguments)
    stopped = threading.Event()

    def stop(_signal: int, _frame: FrameType | None) -> None:
        stopped.set()

    # Before the server starts: a signal may come as soon as its page can be fetched.
    signal.signal(signal.SIGTERM, stop)
    signal.signal(signal.SIGINT, stop)
    feed = WorldFeed(api=options.api, token=os.environ.get("MACTA_TOKEN", ""), world=options.world)
    Viewer(feed=feed, port=options.port, stopped=stopped).run(
        as_long_as=lambda: os.getppid() == options.parent
    )


if __name__ == "__main__":
    main()
