"""Soccer: an attacker and a defender, who change roles after each goal, against a lone opponent.

A referee's hand does what robots cannot: it lays the ball on the spot once all are home, and back on the pitch if it
lies at a wall, or has not moved for half a minute.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from benchmarks.demonstrations.stage import Stage
from robots.deliberative.terms import Term

OURS = ("alice", "bob")
ALL = (*OURS, "carl")
BALL = "ball"
LINE_M, POST_M = 4.0, 1.2
"""A ball past the line between the posts is a goal once the robots have noticed; their line is 5 cm farther."""
OUT_M = (3.85, 2.9)
"""A ball farther out than this, and in no goal, lies at a wall, where no robot gets behind it."""
STILL_S, STILL_M = 30.0, 0.1
"""A ball that has moved less than this in that time lies where nobody gets at it."""
BACK_M = (3.0, 1.8)
"""Where it is laid back at most."""
HOME_M = 0.5
"""A robot this near its home is there."""
HOMES = {"left_defender": -3 - 1.5j, "attacker": 2 + 0j, "opponent": 3 + 1.8j}
GOALS = 3
MATCH_S = 600.0
RESET_S = 150.0
Roles = Mapping[str, tuple[str, ...]]
"""Robot → its roles, by its own belief."""


@dataclass(slots=True, kw_only=True)
class Match:
    """How a match went.

    `scored`, `conceded`: goals. `changes`: role changes that were honoured, one is requested for each goal scored.
    `resets`: those after which all three robots were at home, in their new roles; one is requested for each goal.
    `outs`: how often the ball was laid back on the pitch. `meetings`: how often two robots' hulls have met.
    `reset_s`: how long each reset took.
    """

    seed: int
    scored: int = 0
    conceded: int = 0
    changes: int = 0
    resets: int = 0
    outs: int = 0
    meetings: int = 0
    took_s: float = 0.0
    reset_s: list[float] = field(default_factory=list)

    @property
    def goals(self) -> int:
        return self.scored + self.conceded

    @property
    def succeeded(self) -> bool:
        """All goals fell, and what was requested after each was done."""
        return self.goals == GOALS and self.changes == self.scored and self.resets == self.goals


class Referee:
    """Watches the ball, by the truth."""

    def __init__(self, stage: Stage) -> None:
        self.crossed = 0
        """The line that it has crossed last since the kick-off: 1 the eastern, -1 the western, 0 none."""
        self._stage = stage
        stage.watch = self._watch

    @property
    def ball(self) -> complex:
        truth = self._stage.simulation.truth().samples[BALL]
        return complex(truth.x_m, truth.y_m)

    @property
    def is_goal(self) -> bool:
        """The ball has crossed a line, and the robots have noticed."""
        return bool(self.crossed) and not any(self._stage.is_believed(name, "playing") for name in ALL)

    @property
    def is_out(self) -> bool:
        """The ball lies at a wall."""
        x_m, y_m = abs(self.ball.real), abs(self.ball.imag)
        return y_m > OUT_M[1] or (x_m > OUT_M[0] and y_m > POST_M)

    def lay(self, ball: complex) -> None:
        self._stage.simulation.put(BALL, (ball.real, ball.imag))

    def kick_off(self) -> None:
        self.lay(0j)
        self.crossed = 0

    def _watch(self) -> None:
        ball = self.ball
        if abs(ball.real) >= LINE_M and abs(ball.imag) <= POST_M:
            self.crossed = 1 if ball.real > 0 else -1


def play(seed: int, loss: float) -> Match:
    """Play until `GOALS` have fallen; start poses, noise and lost messages are drawn from the seed."""
    match = Match(seed=seed)
    with Stage("soccer", seed=seed, loss=loss) as stage:
        referee = Referee(stage)
        stage.run_until(lambda: all(roles(stage).values()), timeout_s=5.0)
        before = roles(stage)
        while match.goals < GOALS and stage.now_s < MATCH_S:
            lay = referee.ball
            stage.run_until(lambda: referee.is_goal or referee.is_out, timeout_s=STILL_S)
            ball = referee.ball
            if referee.is_goal:
                before = note_goal(stage, match, before, is_ours=referee.crossed > 0)
                referee.kick_off()
            elif referee.is_out or abs(ball - lay) < STILL_M:
                match.outs += 1
                referee.lay(complex(_clip(ball.real, BACK_M[0]), _clip(ball.imag, BACK_M[1])))
        match.took_s = stage.now_s
        match.meetings = stage.meetings
    return match


def note_goal(stage: Stage, match: Match, before: Roles, *, is_ours: bool) -> Roles:
    """Score it, and wait until all are home.

    :param before: the roles since the last kick-off. :returns: those from now on.
    """
    match.scored += is_ours
    match.conceded += not is_ours
    fell_s = stage.now_s
    stage.run_until(lambda: not _are_ready(stage), timeout_s=10.0)
    if stage.run_until(lambda: _are_ready(stage) and _are_home(stage), timeout_s=RESET_S):
        match.resets += 1
        match.reset_s.append(stage.now_s - fell_s)
    after = roles(stage)
    match.changes += is_ours and [after[name] for name in OURS] == [before[name] for name in reversed(OURS)]
    return after


def roles(stage: Stage) -> Roles:
    """Robot → its roles, by its own belief."""
    return {name: _args(stage.beliefs(name), "role") for name in ALL}


def _are_ready(stage: Stage) -> bool:
    return all(stage.is_believed(name, "ready") for name in ALL)


def _are_home(stage: Stage) -> bool:
    places = stage.places()
    return all(
        len(held) == 1 and abs(places[name] - HOMES[held[0]]) <= HOME_M for name, held in roles(stage).items()
    )


def _args(beliefs: Sequence[Term], functor: str) -> tuple[str, ...]:
    return tuple(str(one.args[0]) for one in beliefs if one.functor == functor)


def _clip(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
