"""What a goal or a mission's repair waits for: running missions, holds, and robots that are not recruited now."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self


@dataclass(frozen=True, slots=True, kw_only=True)
class Blockers:
    """The missions, holds and robots that may prevent a plan; false if there are none.

    :param missions: each in words; likewise `holds`.
    :param robots: by name, why each is not recruited, in words.
    :param until_s: until when they are waited for at the longest, seconds of the world's clock; None: without end.
    """

    missions: tuple[str, ...] = ()
    holds: tuple[str, ...] = ()
    robots: Mapping[str, str] = field(default_factory=dict)
    until_s: float | None = None

    def __bool__(self) -> bool:
        return bool(self.missions or self.holds or self.robots)

    def __str__(self) -> str:
        robots = [f"{robot}, {why}" for robot, why in sorted(self.robots.items())]
        return " and ".join((*self.missions, *self.holds, *robots))

    @property
    def reason(self) -> str:
        return f"waits for {self}"

    def updated(self, unavailable: Mapping[str, str]) -> Self:
        """The same blockers with the robots' current reasons.

        :param unavailable: by name, why a robot is not recruited now; other robots keep their reasons.
        """
        return replace(
            self, robots={robot: unavailable.get(robot, why) for robot, why in self.robots.items()}
        )

    def to_json(self) -> dict[str, Any]:
        return {
            "missions": list(self.missions),
            "holds": list(self.holds),
            "robots": dict(self.robots),
            "until_s": self.until_s,
        }

    @classmethod
    def from_json(cls, known: Mapping[str, Any]) -> Self:
        """:param known: earlier versions recorded no holds and no end."""
        return cls(
            missions=tuple(known["missions"]),
            holds=tuple(known.get("holds", ())),
            robots=dict(known["robots"]),
            until_s=known.get("until_s"),
        )
