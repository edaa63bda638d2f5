"""A script's life cycle: its delivery, its execution state as reported by the robot, and the orders on it.

Orders (cancel, pause, resume) are numbered, because they may overtake each other on the way to the robot. The last one
is kept in the record until the robot has answered it.
"""

from collections.abc import Mapping, Sequence
from enum import StrEnum
from typing import Any, Protocol

from app.domain.lifecycles.mission import Mission, has_ended, is_paused
from app.domain.lifecycles.transitions import check_transition
from robots.wire import Control, ControlVerb, FailureCategory, ScriptState


class Delivery(StrEnum):
    """The state of a script's delivery to its robot."""

    PENDING = "pending"
    """It is sent until the robot answers."""
    ACKNOWLEDGED = "acknowledged"
    """The robot has agreed to it."""
    REFUSED = "refused"
    """The robot has refused it."""
    WITHDRAWN = "withdrawn"
    """It is no longer to be carried out: its mission or its world has ended, or it was cancelled on the way."""


def script_id(mission_id: str, robot: str, revision: int) -> str:
    """The id of the robot's script for a mission's plan. :param revision: counts the mission's plans from 1."""
    return f"{mission_id}-{robot}" + (f"-{revision}" if revision > 1 else "")


DELIVERABLE = (Delivery.PENDING, Delivery.ACKNOWLEDGED)
"""The deliveries of a script that its robot may carry out."""
TERMINAL_SCRIPTS = frozenset({ScriptState.FINISHED, ScriptState.FAILED, ScriptState.CANCELLED})
"""The states of a script that its robot has ended."""
_ACTIVE = frozenset({ScriptState.ACCEPTED, ScriptState.RUNNING, ScriptState.PAUSED})

_DELIVERIES: Mapping[Delivery, tuple[Delivery, ...]] = {
    Delivery.PENDING: (Delivery.ACKNOWLEDGED, Delivery.REFUSED, Delivery.WITHDRAWN),
    Delivery.ACKNOWLEDGED: (Delivery.WITHDRAWN,),  # its robot was lost, and the world was started again
    Delivery.REFUSED: (),
    Delivery.WITHDRAWN: (),
}
_STATES: Mapping[ScriptState | None, frozenset[ScriptState]] = {
    None: _ACTIVE | TERMINAL_SCRIPTS,  # no report yet
    **dict.fromkeys(_ACTIVE, _ACTIVE | TERMINAL_SCRIPTS),
    **dict.fromkeys(TERMINAL_SCRIPTS, frozenset[ScriptState]()),
}
_FOLLOWED = {ControlVerb.PAUSE: ScriptState.PAUSED, ControlVerb.RESUME: ScriptState.RUNNING}
"""The state of a script after its robot has agreed to an order."""


class Script(Protocol):
    """The fields of a script that its life cycle reads and assigns.

    `control` and `control_number`: the order that the robot has not answered; `orders`: the greatest number given;
    `question`: the id of the open status query, `clearance`: of the open clearance; `stopping`: the robot was ordered
    to cancel; `abandoned`: the robot was declared lost; `heard_at_s`: when it last reported its state (world's clock);
    `doubt`: why the robot's report was held back as implausible, in words; empty if none was.
    """

    id: str
    plan_id: str
    delivery: str
    state: str | None
    detail: str
    category: str | None
    perceived: list[Any]
    heard_at_s: float | None
    stopping: bool
    abandoned: bool
    orders: int
    control: str | None
    control_number: int | None
    question: str | None
    clearance: str | None
    doubt: str


class MissionOfScript(Mission, Protocol):
    """A mission with the plan that it carries out now."""

    plan_id: str


def has_terminated(script: Script) -> bool:
    """True if the robot has ended the script, finished or not."""
    return script.state in TERMINAL_SCRIPTS


def has_failed(script: Script) -> bool:
    """True if the script will not be carried out to its end."""
    ended_badly = has_terminated(script) and script.state != ScriptState.FINISHED
    return script.stopping or script.abandoned or script.delivery == Delivery.REFUSED or ended_badly


def acknowledge(script: Script) -> None:
    _deliver(script, Delivery.ACKNOWLEDGED)


def refuse(script: Script, reason: str) -> None:
    """Note that the robot has refused the script; if it was ordered to cancel it before, the script is cancelled."""
    if script.stopping:
        _deliver(script, Delivery.WITHDRAWN)
        _set_state(script, ScriptState.CANCELLED)
    else:
        _deliver(script, Delivery.REFUSED)
        script.detail = reason
        script.question = None  # the refusal answers it: the robot does not have the script


def hear(script: Script, state: str | None, at_s: float) -> None:
    """Record the state that the robot reported. The newest report counts, not the last to arrive.

    :param at_s: when the robot sent it (world's clock).
    """
    if not has_terminated(script) and at_s >= (script.heard_at_s or 0.0):
        _set_state(script, None if state is None else ScriptState(state))
    script.heard_at_s = max(script.heard_at_s or 0.0, at_s)


def end(
    script: Script,
    state: ScriptState,
    *,
    at_s: float,
    detail: str,
    category: FailureCategory | None,
    perceived: Sequence[Mapping[str, Any]],
) -> None:
    """Record that the robot has ended the script; open orders, queries and clearances are dropped."""
    _set_state(script, state)
    script.heard_at_s = max(script.heard_at_s or 0.0, at_s)
    script.detail = detail
    script.category = category
    script.perceived = list(perceived)
    _settle_all(script)
    if script.delivery == Delivery.PENDING:
        _deliver(script, Delivery.WITHDRAWN if script.stopping else Delivery.ACKNOWLEDGED)


def forget(script: Script, detail: str) -> None:
    """Record that the robot reports that it does not have the script, which then counts as failed."""
    _set_state(script, ScriptState.FAILED)
    script.category = FailureCategory.ROBOT
    script.detail = detail


def withdraw(script: Script) -> None:
    """Stop delivering the script and what belongs to it: its mission has ended."""
    _settle_all(script)
    if script.delivery == Delivery.PENDING:
        _deliver(script, Delivery.WITHDRAWN)


def abandon(script: Script) -> None:
    """Give up the script of a lost robot; the robot is ordered to cancel it when it is heard again."""
    script.abandoned = True
    script.question = None
    script.clearance = None
    if not script.stopping:
        order(script, ControlVerb.CANCEL)


def release_abandoned(script: Script) -> None:
    """Drop the cancellation for a lost robot: its world was started again."""
    script.abandoned = False
    _settle_all(script)
    if script.delivery in DELIVERABLE:
        _deliver(script, Delivery.WITHDRAWN)


def ask(script: Script, question_id: str) -> None:
    """Open a status query to the robot."""
    script.question = question_id


def note_answer(script: Script, question_id: str | None) -> None:
    """Note that the robot has answered a status query; the answer to an earlier query leaves the open one open."""
    if script.question == question_id:
        script.question = None


def doubt(script: Script, why: str) -> bool:
    """Note that a report of the robot is implausible; True if that is new and the script has not ended."""
    if script.doubt or has_terminated(script):
        return False
    script.doubt = why
    return True


def settle_doubt(script: Script) -> None:
    """Note that the robot reports plausibly again."""
    script.doubt = ""


def order(script: Script, verb: ControlVerb) -> None:
    """Give the robot an order, which replaces one that it has not answered yet."""
    script.orders += 1
    script.control = verb.value
    script.control_number = script.orders
    script.stopping = script.stopping or verb is ControlVerb.CANCEL


def unanswered_order(script: Script) -> Control | None:
    """The order that the robot has not answered yet."""
    if script.control is None or script.control_number is None:
        return None
    return Control(script_id=script.id, verb=ControlVerb(script.control), number=script.control_number)


def order_label(control: Control) -> str:
    """The order's name among those on its script; part of message ids."""
    return f"{control.verb.value}:{control.number}"


def settle_order(script: Script) -> None:
    """Note that the robot has answered the order."""
    script.control = None
    script.control_number = None


def settle_clearance(script: Script) -> None:
    """Note that the robot has answered the clearance."""
    script.clearance = None


def follow_order(script: Script, verb: ControlVerb, at_s: float) -> None:
    """Note that the robot has agreed to the order."""
    hear(script, _FOLLOWED.get(verb, script.state), at_s)
    settle_order(script)


def can_be_ordered(script: Script, mission: MissionOfScript) -> bool:
    """True if the script can be paused and resumed.

    While the mission is paused, a script that its robot has not acknowledged is not delivered. A script that is being
    cancelled takes no other order.
    """
    if script.stopping or script.abandoned or script.plan_id != mission.plan_id or has_ended(mission):
        return False
    return script.delivery == Delivery.ACKNOWLEDGED and not has_terminated(script)


def reissue_if_diverged(script: Script, mission: MissionOfScript) -> None:
    """Order a pause or resumption again if all orders are answered, but only one of script and mission is paused."""
    if script.control is not None or not can_be_ordered(script, mission):
        return
    should_pause = is_paused(mission)
    if (script.state == ScriptState.PAUSED) != should_pause:
        order(script, ControlVerb.PAUSE if should_pause else ControlVerb.RESUME)


def _settle_all(script: Script) -> None:
    settle_order(script)
    settle_doubt(script)
    script.question = None
    script.clearance = None


def _deliver(script: Script, delivery: Delivery) -> None:
    check_transition(script.delivery, delivery, _DELIVERIES, what="script's delivery")
    script.delivery = delivery


def _set_state(script: Script, state: ScriptState | None) -> None:
    if state == script.state:
        return
    check_transition(script.state, state, _STATES, what="script")
    script.state = state
