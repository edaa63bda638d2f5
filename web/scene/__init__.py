"""A page's scene: the store drawn once, what moves moved as told. Knows viser, not the service."""

from web.scene.frame import Frame
from web.scene.stage import Stage

__all__ = ["Frame", "Stage"]
