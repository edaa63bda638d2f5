"""A page's scene in viser: the building drawn once, moving bodies updated. Does not depend on the service."""

from web.scene.frame import Frame
from web.scene.page_scene import PageScene

__all__ = ["Frame", "PageScene"]
