"""Clicks on one of many bodies that are drawn as one node."""

from collections.abc import Callable, Sequence

import viser

Click = Callable[[str], None]
"""Told the name of what was clicked on."""


def on_instance(handle: viser.BatchedMeshHandle, names: Sequence[str], tell: Click) -> None:
    """Tell the name of the instance that was clicked on; `names` in the instances' order."""

    def clicked(event: viser.SceneNodePointerEvent[viser.BatchedMeshHandle]) -> None:
        if event.instance_index is not None and event.instance_index < len(names):
            tell(names[event.instance_index])

    handle.on_click(clicked)
