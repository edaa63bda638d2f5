"""The mixed waltz: a robot on wheels and a virtual one dance three rounds of the box, in step by messages alone."""

from dataclasses import dataclass
from math import inf

from benchmarks.demonstrations.stage import Stage
from robots.wire import PacketState

LEAD, FOLLOW = ROBOTS = "fred", "ginger"
FIGURES = 12
"""Three rounds of four."""
OFFSET = 1.2 + 1.2j
"""From the leader to the follower while they are in step, metres."""
GIVE_UP_S = 900.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Waltz:
    """How a waltz went.

    `figures`: that both have ended. `late_s`: how long after the one the other began each figure.
    `apart_m`, `apart_at_most_m`: how far the follower was from its place beside the leader while they danced.
    `closed_m`: how far they ended from where the first round began, the farther one. `nearest_m`: between the hulls.
    """

    seed: int
    figures: int
    bowed: bool
    took_s: float
    late_s: tuple[float, ...]
    apart_m: float
    apart_at_most_m: float
    closed_m: float
    touches: int
    nearest_m: float
    messages: int

    @property
    def succeeded(self) -> bool:
        """All figures, and nobody touched anything or anyone."""
        return self.bowed and self.figures == FIGURES and not self.touches and self.nearest_m > 0


def dance(seed: int, loss: float) -> Waltz:
    """Dance it once; start poses, rocks, noise and lost messages are drawn from the seed."""
    with Stage("waltz", seed=seed, loss=loss) as stage:
        apart_m: list[float] = []
        first: dict[str, complex] = {}
        is_over = False
        while not is_over and stage.now_s < GIVE_UP_S:
            for _ in range(20):
                stage.step()
                at = stage.places()
                for name in ROBOTS:
                    if name not in first and ended_s(stage, name):
                        first[name] = at[name]
                if len(first) == 2 and not is_over:
                    apart_m.append(abs(at[FOLLOW] - at[LEAD] - OFFSET))
                is_over = all(len(ended_s(stage, name)) == FIGURES + 1 for name in ROBOTS)
        closed_m = max((abs(stage.places()[name] - first[name]) for name in first), default=inf)
        stage.run_until(lambda: all(stage.is_believed(name, "bowed") for name in ROBOTS), timeout_s=120.0)
        starts = list(zip(*(begun_s(stage, name) for name in ROBOTS), strict=False))[1:]
        return Waltz(
            seed=seed,
            figures=min(len(ended_s(stage, name)) for name in ROBOTS) - 1,
            bowed=all(stage.is_believed(name, "bowed") for name in ROBOTS),
            took_s=max((ended_s(stage, name)[-1] for name in first), default=inf),
            late_s=tuple(abs(one - other) for one, other in starts),
            apart_m=sum(apart_m) / max(1, len(apart_m)),
            apart_at_most_m=max(apart_m, default=inf),
            closed_m=closed_m,
            touches=sum(stage.touches.values()),
            nearest_m=stage.nearest_m,
            messages=stage.simulation.hub.peer_letters,
        )


def begun_s(stage: Stage, robot: str) -> list[float]:
    """When a robot has begun each figure, the way to its first position included; a second try is no beginning."""
    return [begin for begin, _ in _figures(stage, robot)]


def ended_s(stage: Stage, robot: str) -> list[float]:
    """When it has ended each."""
    return [end for _, end in _figures(stage, robot) if end is not None]


def _figures(stage: Stage, robot: str) -> list[tuple[float, float | None]]:
    figures: list[tuple[float, float | None]] = []
    for name, report in stage.reports:
        if (name, report.tag) != (robot, "MOVE_TO"):
            continue
        is_under_way = bool(figures) and figures[-1][1] is None
        if report.state is PacketState.RUNNING and not is_under_way:
            figures.append((report.at_s, None))
        elif report.state is PacketState.FINISHED and is_under_way:
            figures[-1] = (figures[-1][0], report.at_s)
    return figures
