"""Domain packs: what robots can do, what operators can ask and where, as folders of data (docs/packs.md).

Here: how packs are named in options and settings.
"""

import os
from collections.abc import Sequence

STORE = "store"
"""The pack that ships with Macta, chosen if no other is."""
VARIABLE = "MACTA_PACKS"
SEPARATOR = ","


def split_names(text: str) -> tuple[str, ...]:
    """The names and folders of a setting."""
    return tuple(name.strip() for name in text.split(SEPARATOR) if name.strip())


def chosen_packs(given: Sequence[str] | None) -> tuple[str, ...]:
    """The packs named by a command's options, else by the environment, else the one that ships."""
    return tuple(given or ()) or split_names(os.environ.get(VARIABLE, "")) or (STORE,)
