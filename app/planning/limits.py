"""Planning time and objective of a goal: the installation's limits, and what operators request within them."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from app.domain.errors import Invalid
from app.settings import Settings
from planner import Objective, PlanningRequest


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanningWish:
    """The planning options requested with a goal; None: the installation's default."""

    time_limit_s: float | None = None
    effort_s: float | None = None
    objective: Objective = Objective.MAKESPAN

    def to_json(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def from_json(cls, known: Mapping[str, Any]) -> "PlanningWish":
        return cls(**{**known, "objective": Objective(known.get("objective", Objective.MAKESPAN))})


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanningLimits:
    """The installation's limits.

    :param time_limit_s: for goals that request none.
    :param longest_s: the maximum that a goal may request.
    :param effort_s: time to improve a first plan; None: the engine's default.
    """

    time_limit_s: float = 30.0
    longest_s: float = 600.0
    effort_s: float | None = None
    memory_mb: int = 2048

    @classmethod
    def of(cls, settings: Settings) -> "PlanningLimits":
        """As the settings say."""
        return cls(
            time_limit_s=settings.planning_time_limit_s,
            longest_s=settings.planning_longest_s,
            effort_s=settings.planning_effort_s,
            memory_mb=settings.planning_memory_mb,
        )

    def check(self, wish: PlanningWish) -> None:
        """:raises Invalid: if the wish exceeds the limits."""
        for name, span_s in (("time_limit_s", wish.time_limit_s), ("effort_s", wish.effort_s)):
            if span_s is not None and span_s > self.longest_s:
                raise Invalid(
                    f"{name} {span_s:g} is more than the {self.longest_s:g} s this installation allows "
                    "(MACTA_PLANNING_LONGEST_S)",
                    code="beyond-limits",
                )

    def request(self, wish: PlanningWish) -> PlanningRequest:
        """The engine's request for a wish."""
        effort_s = self.effort_s if wish.effort_s is None else wish.effort_s
        limit_s = self.time_limit_s if wish.time_limit_s is None else wish.time_limit_s
        return PlanningRequest(
            time_limit_s=min(limit_s, self.longest_s),
            effort_s=effort_s,
            objective=wish.objective,
            memory_limit_mb=self.memory_mb,
        )
