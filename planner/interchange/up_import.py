"""The import of unified-planning without ConfigSpace, whose scipy costs half of a planning process's start.

unified-planning 1.3 names ConfigSpace in one annotation and in `Engine.get_configuration_space`, which nothing here
calls, so a checkout's environment is without it (pyproject.toml).
`tests/planner/interchange/test_up_import.py` fails once it needs more of it.
"""

import sys
from types import ModuleType


class ConfigurationSpace:
    """Stands for ConfigSpace's class of that name.

    :raises NotImplementedError: always.
    """

    def __init__(self) -> None:
        raise NotImplementedError("import ConfigSpace before unified-planning to have configuration spaces")


def import_unified_planning() -> None:
    """Import unified-planning's engines, unless somebody has; call with `UNIFIED_PLANNING_LOCK` held."""
    if "unified_planning.engines" in sys.modules or "ConfigSpace" in sys.modules:
        return
    stand_in = ModuleType("ConfigSpace")
    stand_in.ConfigurationSpace = ConfigurationSpace  # type: ignore[attr-defined]
    sys.modules["ConfigSpace"] = stand_in
    try:
        import unified_planning.engines  # noqa: F401
    finally:
        del sys.modules["ConfigSpace"]
