"""How a plan-net differs from the one it replaces, action by action and in words."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from planner.knowledge import GroundAction
from planner.plan_nets.plan_net import PlanNet, PlanNetAction

SHIFT_S = 1.0
"""An action whose start differs by less starts when it did."""

Activity = tuple[str, tuple[str, ...], tuple[tuple[str, str], ...]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """What became of the old plan's actions that had not ended.

    `kept`: old id → new id of what the same robots do with the same arguments, each robot in the same order.
    `reassigned`: likewise for what other robots do now. `dropped` are old ids, `added` new ones. `shifted`: new id →
    seconds by which a kept action starts later (negative: earlier). `later_s`: by how much the plan ends later.
    `elapsed_s`: where the new plan's start lies on the old one's time axis.
    """

    kept: Mapping[str, str]
    reassigned: Mapping[str, str]
    dropped: tuple[str, ...]
    added: tuple[str, ...]
    shifted: Mapping[str, float]
    later_s: float
    elapsed_s: float
    words: tuple[str, ...]

    @property
    def changes(self) -> int:
        """How many of the old actions are not kept."""
        return len(self.dropped) + len(self.reassigned)


def compare(old: Sequence[PlanNetAction], new: PlanNet, *, elapsed_s: float = 0.0) -> Difference:
    """The difference between what was left of the old plan and the new plan.

    :param old: the actions that had not ended.
    :param elapsed_s: since the old plan's start; the new one's is now.
    """
    kept = _kept(old, new.actions)
    by_id = {action.id: action for action in old}
    new_by_id = {action.id: action for action in new.actions}
    gone = [action for action in old if action.id not in kept]
    come = [action for action in new.actions if action.id not in set(kept.values())]
    reassigned = _reassigned(gone, come)
    ends_s = max((action.earliest_end_s for action in old), default=elapsed_s) - elapsed_s
    shifts = {
        other: round(new_by_id[other].earliest_start_s - max(0.0, by_id[one].earliest_start_s - elapsed_s), 3)
        for one, other in kept.items()
    }
    dropped = [action for action in gone if action.id not in reassigned]
    added = [action for action in come if action.id not in set(reassigned.values())]
    shifted = {name: shift_s for name, shift_s in shifts.items() if abs(shift_s) >= SHIFT_S}
    later_s = round(new.makespan_s - ends_s, 3)
    words = [
        f"{len(kept)} of {len(old)} actions kept, {_ending(later_s)}",
        *(f"dropped: {action.description}" for action in dropped),
        *(f"{new_by_id[b].description}, instead of {_team(by_id[a])}" for a, b in reassigned.items()),
        *(f"new: {action.description}" for action in added),
        *_shifts(shifted, new_by_id),
    ]
    return Difference(
        kept=kept,
        reassigned=reassigned,
        dropped=tuple(action.id for action in dropped),
        added=tuple(action.id for action in added),
        shifted=shifted,
        later_s=later_s,
        elapsed_s=round(elapsed_s, 3),
        words=tuple(words),
    )


def _activity(action: PlanNetAction) -> Activity:
    return action.tag, action.agents, tuple(sorted(action.arguments.items()))


def by_anyone(action: GroundAction) -> Activity:
    """The activity, whoever does it."""
    place = {agent: f"agent {number}" for number, agent in enumerate(action.agents)}
    team = "+".join(action.agents)
    arguments = ((n, place.get(v, "team" if v == team else v)) for n, v in sorted(action.arguments.items()))
    return action.tag, (), tuple(arguments)


def _kept(old: Sequence[PlanNetAction], new: Sequence[PlanNetAction]) -> dict[str, str]:
    """Old id → new id; for each robot a longest common subsequence of what it does."""
    matches: dict[str, dict[str, str]] = defaultdict(dict)
    for robot in {agent for action in old for agent in action.agents}:
        before, after = ([action for action in side if robot in action.agents] for side in (old, new))
        for one, other in _common([_activity(a) for a in before], [_activity(a) for a in after]):
            matches[before[one].id][robot] = after[other].id
    kept = {}
    for action in old:
        found = matches[action.id]
        if len(found) == len(action.agents) and len(set(found.values())) == 1:
            kept[action.id] = next(iter(found.values()))
    return kept


def _common(one: Sequence[Activity], other: Sequence[Activity]) -> Iterator[tuple[int, int]]:
    """The positions of a longest common subsequence."""
    longest = [[0] * (len(other) + 1) for _ in range(len(one) + 1)]
    for i in reversed(range(len(one))):
        for j in reversed(range(len(other))):
            longest[i][j] = (
                1 + longest[i + 1][j + 1] if one[i] == other[j] else max(longest[i + 1][j], longest[i][j + 1])
            )
    i = j = 0
    while i < len(one) and j < len(other):
        if one[i] == other[j]:
            yield i, j
            i = i + 1
            j = j + 1
        elif longest[i + 1][j] >= longest[i][j + 1]:
            i += 1
        else:
            j += 1


def _reassigned(gone: Sequence[PlanNetAction], come: Sequence[PlanNetAction]) -> dict[str, str]:
    """The actions gone that other robots do now: old id → new id, in order."""
    open_: dict[Activity, list[PlanNetAction]] = defaultdict(list)
    for action in come:
        open_[by_anyone(action)].append(action)
    pairs = {}
    for action in gone:
        others = open_[by_anyone(action)]
        heir = next((other for other in others if other.agents != action.agents), None)
        if heir is not None:
            others.remove(heir)
            pairs[action.id] = heir.id
    return pairs


def _ending(later_s: float) -> str:
    if abs(later_s) < SHIFT_S:
        return "ends when it did"
    return f"ends {abs(later_s):.0f} s {'later' if later_s > 0 else 'earlier'}"


def _shifts(shifted: Mapping[str, float], actions: Mapping[str, PlanNetAction]) -> Iterator[str]:
    """A sentence for each team: how many of its kept actions start later and earlier, and by how much."""
    by_team: dict[str, list[float]] = defaultdict(list)
    for name, shift_s in shifted.items():
        by_team[_team(actions[name])].append(shift_s)
    for team, shifts in sorted(by_team.items()):
        for word, spans in (
            ("later", [s for s in shifts if s > 0]),
            ("earlier", [-s for s in shifts if s < 0]),
        ):
            if spans:
                least = f"{min(spans):.0f}"
                most = f"{max(spans):.0f}"
                span = least if least == most else f"{least} to {most}"
                yield f"{team} starts {len(spans)} action{'s' * (len(spans) > 1)} {span} s {word}"


def _team(action: PlanNetAction) -> str:
    return " and ".join(action.agents)
