"""How far a mission has come, and what was tried to recover it, as the record says."""

from collections.abc import Sequence
from typing import Any

from app.domain.recovery_rules import Trouble
from app.store import MissionRow, ScriptRow
from planner import PlanNet
from planner.repair import MissionProgress
from robots.wire import PacketState

NOT_BEGUN = frozenset({PacketState.WAITING, PacketState.INITIALIZING})
Attempt = dict[str, Any]


def begun(scripts: Sequence[ScriptRow]) -> frozenset[str]:
    """The actions that a robot of one plan is known to have begun."""
    return frozenset(
        action
        for script in scripts
        for action, known in script.packets.items()
        if known["state"] not in NOT_BEGUN
    )


def done(scripts: Sequence[ScriptRow]) -> frozenset[str]:
    """The actions of which all robots of one plan that take part have reported the end: the facts tell of them."""
    finished, left = set[str](), set[str]()
    for script in scripts:
        for packet in script.body["packets"]:
            state = script.packets.get(packet["id"], {}).get("state")
            (finished if state == PacketState.FINISHED else left).add(packet["id"])
    return frozenset(finished - left)


def progress_of(
    mission: MissionRow,
    scripts: Sequence[ScriptRow],
    plan_net: PlanNet,
    *,
    without: frozenset[str],
    now_s: float,
) -> MissionProgress:
    """How far the plan is that the mission carries out, once all its robots have stopped.

    :param scripts: of that plan.
    :param without: the robots that are not to be planned with any more.
    """
    begun_s = mission.started_at_s if mission.revised_at_s is None else mission.revised_at_s
    known = {action.id for action in plan_net.actions}
    return MissionProgress(
        done=done(scripts) & known,
        lost=without,
        elapsed_s=0.0 if begun_s is None else max(0.0, now_s - begun_s),
    )


def troubles_of(mission: MissionRow) -> list[Trouble]:
    """All that has befallen the mission so far."""
    return [Trouble.from_json(one) for attempt in mission.attempts for one in attempt["troubles"]]


def begin_attempt(mission: MissionRow, troubles: Sequence[Trouble], **more: Any) -> Attempt:
    """Note that the mission is to be recovered once more."""
    attempt: Attempt = {
        "number": len(mission.attempts) + 1,
        "troubles": [one.to_json() for one in troubles],
        "measure": None,
        "without": [],
        "plan_id": None,
        "outcome": "planning",
        "detail": "",
        **more,
    }
    mission.attempts = [*mission.attempts, attempt]
    return attempt


def note(mission: MissionRow, **news: Any) -> None:
    """Note what became of the mission's last attempt."""
    *before, last = mission.attempts
    mission.attempts = [*before, {**last, **news}]


def no_way(mission: MissionRow) -> str:
    """Why the last attempt came to nothing, in words; empty if it has not."""
    if not mission.attempts or mission.attempts[-1]["outcome"] not in ("no plan", "rejected"):
        return ""
    return str(mission.attempts[-1]["detail"])
