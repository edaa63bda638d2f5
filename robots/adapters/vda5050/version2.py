"""Translates messages between VDA 5050 2.x and 3.0, field by field (our reading of the two versions' schemas).

Both directions work on JSON objects. What the other version lacks is left out, or takes its nearest value: an ellipse
of permitted deviation becomes a circle within it, a critical or urgent error of 3.0 a fatal one or a warning of 2.x.
Instant actions of 2.x are written under `actions` (2.1) and `instantActions` (2.0), both names being in use.
"""

from collections.abc import Callable, Mapping
from typing import Any

from robots.adapters.vda5050.topics import Topic

Json = dict[str, Any]

_STATE = {"agvPosition": "mobileRobotPosition", "batteryState": "powerSupply"}
_POSITION = {"positionInitialized": "localized"}
_BATTERY = {"batteryCharge": "stateOfCharge", "reach": "range"}
_SAFETY = {"eStop": "activeEmergencyStop"}
_ACTION = {"actionDescription": "actionDescriptor"}
_ACTION_STATE = {"actionDescription": "actionDescriptor", "resultDescription": "actionResult"}
_NODE = {"nodeDescription": "nodeDescriptor"}
_EDGE = {
    "edgeDescription": "edgeDescriptor",
    "maxSpeed": "maximumSpeed",
    "maxHeight": "maximumHeight",
    "minHeight": "minimumLoadHandlingDeviceHeight",
}
_INFO = {"infoDescription": "infoDescriptor"}
_TYPE = {
    "agvKinematic": "mobileRobotKinematics",
    "agvClass": "mobileRobotClass",
    "maxLoadMass": "maximumLoadMass",
}
_PHYSICAL = {
    "speedMin": "minimumSpeed",
    "speedMax": "maximumSpeed",
    "angularSpeedMin": "minimumAngularSpeed",
    "angularSpeedMax": "maximumAngularSpeed",
    "accelerationMax": "maximumAcceleration",
    "decelerationMax": "maximumDeceleration",
    "heightMin": "minimumHeight",
    "heightMax": "maximumHeight",
}
_LIMITS = {"maxStringLens": "maximumStringLengths", "maxArrayLens": "maximumArrayLengths"}
_STRINGS = {
    "msgLen": "maximumMessageLength",
    "topicSerialLen": "maximumTopicSerialLength",
    "topicElemLen": "maximumTopicElementLength",
    "idLen": "maximumIdLength",
    "loadIdLen": "maximumLoadIdLength",
}
_TIMING = {"minOrderInterval": "minimumOrderInterval", "minStateInterval": "minimumStateInterval"}
_FEATURES = {"agvActions": "mobileRobotActions"}
_FACTSHEET = {"agvGeometry": "mobileRobotGeometry", "vehicleConfig": "mobileRobotConfiguration"}
_SUPPORTED = {"resultDescription": "actionResult"}

_KINEMATICS = {"DIFF": "DIFFERENTIAL", "OMNI": "OMNIDIRECTIONAL", "THREEWHEEL": "THREE_WHEEL"}
_NAVIGATION = {"AUTONOMOUS": "FREELY_NAVIGATING"}
_MODES = {"TEACHIN": "TEACH_IN"}
_MODES_BACK = {"TEACH_IN": "TEACHIN", "STARTUP": "SERVICE", "INTERVENED": "MANUAL"}
_LEVELS_BACK = {"URGENT": "WARNING", "CRITICAL": "FATAL"}
_ERRORS_BACK = {
    "VALIDATION_FAILURE": "validationError",
    "INVALID_ORDER": "orderError",
    "INVALID_ORDER_ACTION": "orderError",
    "OTHER_ORDER_ACTIVE": "orderError",
    "START_NODE_OUT_OF_RANGE": "orderError",
    "OUTDATED_ORDER_UPDATE": "orderUpdateError",
    "SAME_ORDER_UPDATE_ID": "orderUpdateError",
    "ORDER_UPDATE_FOLLOWING_CANCEL": "orderUpdateError",
    "NO_ROUTE_TO_TARGET": "noRouteError",
    "NO_ORDER_TO_CANCEL": "noOrderToCancel",
}
"""Types of errors that 2.x names otherwise."""
_STOPS = {"AUTOACK": "MANUAL"}
_CONNECTIONS = {"CONNECTIONBROKEN": "CONNECTION_BROKEN"}
_CONNECTIONS_BACK = {"CONNECTION_BROKEN": "CONNECTIONBROKEN", "HIBERNATING": "ONLINE"}
_BLOCKING_BACK = {"SINGLE": "SOFT"}
_STATUS_BACK = {"RETRIABLE": "RUNNING"}
INSTANT = frozenset(
    {
        "startPause",
        "stopPause",
        "startCharging",
        "stopCharging",
        "initPosition",
        "stateRequest",
        "logReport",
        "cancelOrder",
        "factsheetRequest",
        "enableMap",
        "downloadMap",
        "deleteMap",
    }
)
"""Types of actions that 2.x reports among those of the order."""


def from_version2(topic: Topic, message: Json) -> Json:
    """A message of 2.x as one of 3.0."""
    read: Mapping[Topic, Callable[[Json], Json]] = {
        Topic.ORDER: _order_read,
        Topic.INSTANT_ACTIONS: _instant_read,
        Topic.STATE: _state_read,
        Topic.VISUALIZATION: _visualization_read,
        Topic.CONNECTION: lambda one: _mapped(dict(one), "connectionState", _CONNECTIONS),
        Topic.FACTSHEET: _factsheet_read,
    }
    return read[topic](message)


def to_version2(topic: Topic, message: Json) -> Json:
    """A message of 3.0 as one of 2.1, which 2.0 understands, too."""
    write: Mapping[Topic, Callable[[Json], Json]] = {
        Topic.ORDER: _order_written,
        Topic.INSTANT_ACTIONS: _instant_written,
        Topic.STATE: _state_written,
        Topic.VISUALIZATION: _visualization_written,
        Topic.CONNECTION: lambda one: _mapped(dict(one), "connectionState", _CONNECTIONS_BACK),
        Topic.FACTSHEET: _factsheet_written,
    }
    return write[topic](message)


def _renamed(part: Any, names: Mapping[str, str]) -> Json:
    return {names.get(key, key): value for key, value in part.items()} if isinstance(part, dict) else {}


def _back(names: Mapping[str, str]) -> dict[str, str]:
    return {new: old for old, new in names.items()}


def _mapped(part: Json, key: str, values: Mapping[str, str]) -> Json:
    if isinstance(part.get(key), str):
        part[key] = values.get(part[key], part[key])
    return part


def _each(part: Json, key: str, change: Callable[[Json], Json]) -> None:
    if isinstance(part.get(key), list):
        part[key] = [change(one) if isinstance(one, dict) else one for one in part[key]]


def _inner(part: Json, key: str, change: Callable[[Json], Json]) -> None:
    if isinstance(part.get(key), dict):
        part[key] = change(part[key])


# Orders


def _position_read(position: Json) -> Json:
    now = dict(position)
    deviation = now.pop("allowedDeviationXy", None)
    deviation = now.get("allowedDeviationXY", deviation)
    if isinstance(deviation, int | float):
        now["allowedDeviationXY"] = {"a": deviation, "b": deviation, "theta": 0.0}
    return now


def _position_written(position: Json) -> Json:
    now = dict(position)
    ellipse = now.pop("allowedDeviationXY", None)
    if isinstance(ellipse, dict):
        radius_m = min(ellipse["a"], ellipse["b"])
        now["allowedDeviationXY"] = radius_m
        now["allowedDeviationXy"] = radius_m
    return now


def _node_read(node: Json) -> Json:
    now = _renamed(node, _NODE)
    _inner(now, "nodePosition", _position_read)
    _each(now, "actions", lambda one: _renamed(one, _ACTION))
    return now


def _node_written(node: Json) -> Json:
    now = _renamed(node, _back(_NODE))
    _inner(now, "nodePosition", _position_written)
    _each(now, "actions", _action_written)
    return now


def _action_written(action: Json) -> Json:
    now = _renamed(action, _back(_ACTION))
    now.pop("retriable", None)
    return _mapped(now, "blockingType", _BLOCKING_BACK)


def _edge_read(edge: Json) -> Json:
    now = _renamed(edge, _EDGE)
    _each(now, "actions", lambda one: _renamed(one, _ACTION))
    return now


def _edge_written(edge: Json, ends: Mapping[int, str]) -> Json:
    now = _renamed(edge, _back(_EDGE))
    now["startNodeId"] = ends.get(edge["sequenceId"] - 1, "")
    now["endNodeId"] = ends.get(edge["sequenceId"] + 1, "")
    _each(now, "actions", _action_written)
    return now


def _order_read(order: Json) -> Json:
    now = dict(order)
    _each(now, "nodes", _node_read)
    _each(now, "edges", _edge_read)
    return now


def _order_written(order: Json) -> Json:
    now = dict(order)
    now.pop("orderDescription", None)
    ends = {node["sequenceId"]: node["nodeId"] for node in order["nodes"]}
    _each(now, "nodes", _node_written)
    _each(now, "edges", lambda edge: _edge_written(edge, ends))
    return now


def _instant_read(message: Json) -> Json:
    now = dict(message)
    if "instantActions" in now:
        now.setdefault("actions", now.pop("instantActions"))
    _each(now, "actions", lambda one: _renamed(one, _ACTION))
    return now


def _instant_written(message: Json) -> Json:
    now = dict(message)
    _each(now, "actions", _action_written)
    now["instantActions"] = now["actions"]
    return now


# States


def _robot_position_read(position: Json) -> Json:
    return _renamed(position, _POSITION)


def _robot_position_written(position: Json) -> Json:
    return _renamed(position, _back(_POSITION))


def _state_read(state: Json) -> Json:
    now = _renamed(state, _STATE)
    _inner(now, "mobileRobotPosition", _robot_position_read)
    _inner(now, "powerSupply", lambda one: _renamed(one, _BATTERY))
    _inner(now, "safetyState", lambda one: _mapped(_renamed(one, _SAFETY), "activeEmergencyStop", _STOPS))
    _each(now, "nodeStates", _node_read)
    _each(now, "edgeStates", _edge_read)
    _each(now, "actionStates", lambda one: _renamed(one, _ACTION_STATE))
    _each(now, "information", lambda one: _renamed(one, _INFO))
    # NOTE: in 2.x instant actions are among the order's; an order would never become idle by a startPause that failed.
    actions = now.get("actionStates")
    if isinstance(actions, list) and "instantActionStates" not in now:
        instant = [one for one in actions if isinstance(one, dict) and one.get("actionType") in INSTANT]
        charging = [one for one in instant if str(one.get("actionType")).endswith("Charging")]
        now["instantActionStates"] = [one for one in instant if one not in charging]
        now["actionStates"] = [one for one in actions if one not in now["instantActionStates"]]
    return _mapped(now, "operatingMode", _MODES)


def _state_written(state: Json) -> Json:
    now = _renamed(state, _back(_STATE))
    now["actionStates"] = [*now.get("actionStates", ()), *now.pop("instantActionStates", ())]
    for key in (
        "zoneSets",
        "plannedPath",
        "intermediatePath",
        "zoneRequests",
        "edgeRequests",
        "zoneActionStates",
    ):
        now.pop(key, None)
    _inner(now, "agvPosition", _robot_position_written)
    _inner(now, "batteryState", lambda one: _renamed(one, _back(_BATTERY)))
    _inner(now, "safetyState", lambda one: _renamed(one, _back(_SAFETY)))
    _each(now, "nodeStates", _node_written)
    _each(now, "edgeStates", lambda one: _renamed(one, _back(_EDGE)))
    _each(
        now,
        "actionStates",
        lambda one: _mapped(_renamed(one, _back(_ACTION_STATE)), "actionStatus", _STATUS_BACK),
    )
    _each(now, "information", lambda one: _renamed(one, _back(_INFO)))
    _each(now, "errors", _error_written)
    return _mapped(now, "operatingMode", _MODES_BACK)


def _error_written(error: Json) -> Json:
    now = _mapped(dict(error), "errorLevel", _LEVELS_BACK)
    return _mapped(now, "errorType", _ERRORS_BACK)


def _visualization_read(message: Json) -> Json:
    now = _renamed(message, _STATE)
    _inner(now, "mobileRobotPosition", _robot_position_read)
    return now


def _visualization_written(message: Json) -> Json:
    now = _renamed(message, _back(_STATE))
    now.pop("referenceStateHeaderId", None)
    _inner(now, "agvPosition", _robot_position_written)
    return now


# Factsheets


def _factsheet_read(sheet: Json) -> Json:
    now = _renamed(sheet, _FACTSHEET)
    _inner(now, "typeSpecification", _type_read)
    _inner(now, "physicalParameters", lambda one: _renamed(one, _PHYSICAL))
    _inner(now, "protocolLimits", lambda one: _limits(one, back=False))
    _inner(now, "protocolFeatures", lambda one: _features(one, back=False))
    return now


def _factsheet_written(sheet: Json) -> Json:
    now = _renamed(sheet, _back(_FACTSHEET))
    _inner(now, "typeSpecification", _type_written)
    _inner(now, "physicalParameters", lambda one: _renamed(one, _back(_PHYSICAL)))
    _inner(now, "protocolLimits", lambda one: _limits(one, back=True))
    _inner(now, "protocolFeatures", lambda one: _features(one, back=True))
    return now


def _type_read(kind: Json) -> Json:
    now = _mapped(_renamed(kind, _TYPE), "mobileRobotKinematics", _KINEMATICS)
    if isinstance(now.get("navigationTypes"), list):
        now["navigationTypes"] = [_NAVIGATION.get(one, one) for one in now["navigationTypes"]]
    return now


def _type_written(kind: Json) -> Json:
    now = _mapped(_renamed(kind, _back(_TYPE)), "agvKinematic", _back(_KINEMATICS))
    now.setdefault("agvKinematic", "DIFF")
    now.pop("mobileRobotKinematic", None)
    if isinstance(now.get("navigationTypes"), list):
        now["navigationTypes"] = [_back(_NAVIGATION).get(one, one) for one in now["navigationTypes"]]
    return now


def _limits(limits: Json, *, back: bool) -> Json:
    names = [_LIMITS, _STRINGS, _TIMING]
    outer, strings, timing = [_back(one) for one in names] if back else names
    now = _renamed(limits, outer)
    _inner(now, "maxStringLens" if back else "maximumStringLengths", lambda one: _renamed(one, strings))
    _inner(now, "timing", lambda one: _renamed(one, timing))
    return now


def _features(features: Json, *, back: bool) -> Json:
    now = _renamed(features, _back(_FEATURES) if back else _FEATURES)
    _each(
        now,
        "agvActions" if back else "mobileRobotActions",
        _supported_written if back else (lambda one: _renamed(one, _SUPPORTED)),
    )
    return now


def _supported_written(action: Json) -> Json:
    now = _renamed(action, _back(_SUPPORTED))
    now.pop("pauseAllowed", None)
    now.pop("cancelAllowed", None)
    # NOTE: by the published schema of 2.1 no list of blocking types is valid; they are optional.
    now.pop("blockingTypes", None)
    return now
