"""Domain packs: what robots can do, what operators can ask and where, as folders of data (docs/packs.md).

Here: how packs are named in options and settings.
"""

import os
from collections.abc import Sequence

STORE = "store"
"""The pack that is chosen if no other is."""
SURVEY = "survey"
"""Outdoor sites and the behavioural suite."""
MAIN_WORLD = "sample_store"
"""The world of `store` that is meant if none is named."""
SHIPPED = (STORE, SURVEY)
"""The packs that ship with Macta."""
VARIABLE = "MACTA_PACKS"
SEPARATOR = ","


def split_names(text: str) -> tuple[str, ...]:
    """The names and folders of a setting."""
    return tuple(name.strip() for name in text.split(SEPARATOR) if name.strip())


def chosen_packs(given: Sequence[str] | None) -> tuple[str, ...]:
    """The packs named by a command's options, else by the environment, else the one that ships."""
    return tuple(given or ()) or split_names(os.environ.get(VARIABLE, "")) or (STORE,)
