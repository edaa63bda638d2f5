"""What a vehicle's state says of an order and of the part of it that is to be carried out. Pure."""

from dataclasses import dataclass

from robots.adapters.vda5050.messages import ActionStatus, State, VehicleError
from robots.adapters.vda5050.orders import Leg
from robots.data import StrEnum


class Standing(StrEnum):
    """How a vehicle stands to an order's update."""

    UNKNOWN = "unknown"
    """It has another order, or none, and may not have received this one."""
    OUTDATED = "outdated"
    """It has the order, but not yet this update."""
    ACCEPTED = "accepted"
    """It has the update."""
    REJECTED = "rejected"
    """It says that it does not take it."""


PASSING = frozenset({"OTHER_ORDER_ACTIVE", "OUTDATED_ORDER_UPDATE", "SAME_ORDER_UPDATE_ID"})
"""Errors about an order that is sent again, or that the vehicle takes once it has given up the one it has."""


def standing(state: State, order_id: str, update_id: int) -> tuple[Standing, str]:
    """How the vehicle stands to an update of an order, and its reason if it rejects it."""
    if state.order_id == order_id and state.order_update_id >= update_id:
        return Standing.ACCEPTED, ""
    for error in state.errors:
        numbered = error.reference("orderUpdateId")
        is_ours = error.reference("orderId") == order_id and numbered in (None, str(update_id))
        if is_ours and error.error_type not in PASSING:
            return Standing.REJECTED, error.words
    return (Standing.OUTDATED if state.order_id == order_id else Standing.UNKNOWN), ""


class Stage(StrEnum):
    """How far a leg has come."""

    AHEAD = "ahead"
    """Its first edge is not entered yet."""
    DRIVING = "driving"
    """On the way, or between its actions."""
    ACTING = "acting"
    """One of its actions is going on."""
    PAUSED = "paused"
    """The vehicle is paused."""
    DONE = "done"
    """Its decision point is traversed and all its actions have finished."""
    FAILED = "failed"
    """It will not be done; there is a reason."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LegProgress:
    """How far a leg has come, in words too where that tells more."""

    stage: Stage
    reason: str = ""


def leg_progress(state: State, leg: Leg) -> LegProgress:
    """How far a leg has come whose update the vehicle has accepted.

    Our choice: an action that a vehicle holds as retriable has failed: how to go on is the mission's to decide.
    """
    statuses = {action.action_id: state.status_of(action.action_id) for action in leg.actions}
    is_there = state.last_node_sequence_id >= leg.end.sequence_id and not any(
        one.sequence_id <= leg.end.sequence_id for one in state.node_states
    )
    if is_there and all(status is ActionStatus.FINISHED for status in statuses.values()):
        return LegProgress(stage=Stage.DONE)
    if (failure := _failure(state, leg)) is not None:
        return LegProgress(stage=Stage.FAILED, reason=failure)
    if state.paused:
        return LegProgress(stage=Stage.PAUSED)
    if any(status not in (None, ActionStatus.WAITING, ActionStatus.FINISHED) for status in statuses.values()):
        return LegProgress(stage=Stage.ACTING)
    entered = state.driving or state.last_node_sequence_id >= leg.edges[0].sequence_id
    return LegProgress(stage=Stage.DRIVING if entered else Stage.AHEAD)


def _failure(state: State, leg: Leg) -> str | None:
    """Why a leg that is not done will not be; None if it may be."""
    for action in leg.actions:
        if state.status_of(action.action_id) in (ActionStatus.FAILED, ActionStatus.RETRIABLE):
            return f"{action.action_type} failed{_because(state, action.action_id)}"
    if (error := stopping_error(state, leg)) is not None:
        return error.words
    if not state.is_idle:
        return None
    mode = "" if state.operating_mode.takes_orders else f": its operating mode is {state.operating_mode}"
    return f"the vehicle has given up its order{mode}"


def stopping_error(state: State, leg: Leg | None = None) -> VehicleError | None:
    """The active error that ends the order; None without one. Errors about other orders or actions are left out."""
    ours = set() if leg is None else {action.action_id for action in leg.actions}
    for error in state.errors:
        order = error.reference("orderId")
        action = error.reference("actionId")
        is_about_other = (order is not None and order != state.order_id) or (
            action is not None and action not in ours
        )
        if error.error_level.stops_the_order and not is_about_other:
            return error
    return None


def _because(state: State, action_id: str) -> str:
    words = [one.words for one in state.errors if one.reference("actionId") == action_id]
    result = next((one.action_result for one in state.action_states if one.action_id == action_id), None)
    said = "; ".join(words) or result or ""
    return f": {said}" if said else ""
