"""The planners that are compared, each as an anytime planner of unified-planning."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.domains.model import Form

OURS = "macta"
PARTIAL_ORDER = "partial-order"
"""A yardstick of UCPOP's kind, ours and no part of the product (benchmarks/domains/partial_order.py)."""
_DURATION = re.compile(r"(\[[\d.]+\])\)")


@dataclass(frozen=True, slots=True, kw_only=True)
class Planner:
    """How a planner is made, in the process that runs it, and the forms of problems that it takes."""

    make: Callable[[], Any]
    forms: tuple[Form, ...] = tuple(Form)


def _ours() -> Any:
    from planner.up_engine import MactaEngine

    return MactaEngine()


def _fast_downward() -> Any:
    from up_fast_downward import FastDownwardPDDLPlanner

    return FastDownwardPDDLPlanner()


def _lpg() -> Any:
    from up_lpg.lpg_planner import LPGAnytimeEngine

    class Lpg(LPGAnytimeEngine):  # type: ignore[misc]
        """LPG with a seed, and with durations read as it writes them: `[5.0000])`, which its wheel does not read."""

        def __init__(self) -> None:
            super().__init__()
            self._options = ["-seed", "1"]

        def _plan_from_file(self, problem: Any, plan_filename: str, get_item_named: Any) -> Any:
            file = Path(plan_filename)
            if file.is_file():
                plain = file.with_suffix(".plain")
                plain.write_text(_DURATION.sub(r"\1", file.read_text()))
                file = plain
            return super()._plan_from_file(problem, str(file), get_item_named)

    return Lpg()


def _aries() -> Any:
    from up_aries import Aries

    return Aries()


def _partial_order() -> Any:
    from benchmarks.domains.partial_order import PartialOrderPlanner

    return PartialOrderPlanner()


PLANNERS: Mapping[str, Planner] = {
    OURS: Planner(make=_ours),
    "fast-downward": Planner(make=_fast_downward, forms=(Form.CLASSICAL,)),
    "lpg": Planner(make=_lpg),
    "aries": Planner(make=_aries),
    PARTIAL_ORDER: Planner(make=_partial_order, forms=(Form.CLASSICAL,)),
}
