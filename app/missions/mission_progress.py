"""The progress of a mission's plan according to the record."""

from collections.abc import Mapping, Sequence

from app.store import MissionRow, ScriptRow
from planner import PlanNet
from planner.repair import MissionProgress
from robots.wire import PacketState

NOT_BEGUN = frozenset({PacketState.WAITING, PacketState.INITIALIZING})


def begun(scripts: Sequence[ScriptRow]) -> frozenset[str]:
    """The actions that a robot of one plan is known to have begun."""
    return frozenset(
        action
        for script in scripts
        for action, known in script.packets.items()
        if known["state"] not in NOT_BEGUN
    )


def done(scripts: Sequence[ScriptRow]) -> frozenset[str]:
    """The actions whose end all their robots have reported, so that the facts have their effects."""
    finished = set[str]()
    left = set[str]()
    for script in scripts:
        for packet in script.body["packets"]:
            state = script.packets.get(packet["id"], {}).get("state")
            (finished if state == PacketState.FINISHED else left).add(packet["id"])
    return frozenset(finished - left)


def _left_s(scripts: Sequence[ScriptRow], plan_net: PlanNet, now_s: float) -> Mapping[str, float]:
    """By action that is under way, how long it still takes if it takes as long as planned."""
    began_s: dict[str, float] = {}
    for script in scripts:
        for action, known in script.packets.items():
            if known["state"] == PacketState.RUNNING and known.get("started_at_s") is not None:
                began_s[action] = min(began_s.get(action, now_s), known["started_at_s"])
    ended = done(scripts)
    return {
        action.id: max(0.0, action.duration_s - (now_s - began_s[action.id]))
        for action in plan_net.actions
        if action.id in began_s and action.id not in ended
    }


def progress_of(
    mission: MissionRow,
    scripts: Sequence[ScriptRow],
    plan_net: PlanNet,
    *,
    without: frozenset[str],
    now_s: float,
    runs_on: bool = False,
) -> MissionProgress:
    """The progress of the mission's current plan, once all its robots have stopped.

    :param scripts: of that plan.
    :param without: the robots excluded from planning.
    :param runs_on: they have not stopped, and what is under way is to end.
    """
    begun_s = mission.started_at_s if mission.revised_at_s is None else mission.revised_at_s
    known = {action.id for action in plan_net.actions}
    return MissionProgress(
        done=done(scripts) & known,
        under_way=_left_s(scripts, plan_net, now_s) if runs_on else {},
        lost=without,
        elapsed_s=0.0 if begun_s is None else max(0.0, now_s - begun_s),
    )
