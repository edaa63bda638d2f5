"""`macta robot twin`: a robot and its simulated twin take turns, on a running service."""

from typing import TYPE_CHECKING
from urllib.parse import quote

from app.cli.service_calls import answer_of
from app.domain.errors import Invalid

if TYPE_CHECKING:
    from httpx2 import Client


def twin(service: "Client", robot: str, *, is_simulated: bool | None) -> str:
    """Replace a robot by its simulated twin, or the other way round; says who speaks for it then.

    :param is_simulated: None: only say who speaks for it now.
    :raises Invalid: if the service refuses, with its reason.
    """
    known = answer_of(service, "GET", f"/v1/robots/{quote(robot, safe='')}")
    path = f"/v1/worlds/{quote(known['world'], safe='')}"
    now = _speaker(service, path, robot)
    if is_simulated is None or is_simulated == now:
        return _words(robot, now, verb="is")
    edit = {"edit": "change_robot", "name": robot, "external": not is_simulated}
    reason = "replaced by its simulated twin" if is_simulated else "takes the place of its simulated twin"
    answer_of(service, "POST", f"{path}/changes", {"edits": [edit], "reason": reason})
    return _words(robot, _speaker(service, path, robot), verb="is now")


def _speaker(service: "Client", path: str, robot: str) -> bool:
    """True if the robot is simulated now."""
    robots = answer_of(service, "GET", path)["layout"]["robots"]
    spec = next((one for one in robots if one["name"] == robot), None)
    if spec is None:
        raise Invalid(f"{robot} is no robot; doors, hatches and lifts have no twin")
    return not spec.get("external", False)


def _words(robot: str, is_simulated: bool, *, verb: str) -> str:
    if is_simulated:
        return f"{robot} {verb} simulated"
    return f"{robot} {verb} real: software of its own speaks for it"
