"""The view's scene: the store drawn once, robots and samples moved as told. Knows viser, not the service."""

from web.scene.robots import RobotsView
from web.scene.samples import SamplesView
from web.scene.store import aim_camera, draw_store, light_store

__all__ = ["RobotsView", "SamplesView", "aim_camera", "draw_store", "light_store"]
