"""A page's scene: the store drawn once, what moves moved as told. Knows viser, not the service."""

from web.scene.frame import Frame
from web.scene.page_scene import Stage

__all__ = ["Frame", "Stage"]
