"""`macta rules break`, `step` and `continue`: breakpoints on rules of a running service's simulated robots."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from app.cli.service_calls import answer_of
from app.domain.errors import Invalid

if TYPE_CHECKING:
    from httpx2 import Client


def set_breakpoints(service: "Client", robot: str, rules: Sequence[str], *, clear: bool = False) -> str:
    """Set the robot's breakpoints, or remove them; says where its world stands.

    :param rules: none: only say it.
    :raises Invalid: if the service refuses, with its reason, as the next one.
    """
    if clear and rules:
        raise Invalid("name rules, or --clear to remove all breakpoints of the robot")
    path = f"/v1/robots/{quote(robot, safe='')}/breakpoints"
    if not rules and not clear:
        return _words(answer_of(service, "GET", path))
    return _words(answer_of(service, "PUT", path, {"rules": list(rules)}))


def go_on(service: "Client", robot: str, *, one_cycle: bool) -> str:
    """Let the robot's world leave the breakpoint at which it stands; says where it stands then."""
    verb = "step" if one_cycle else "continue"
    return _words(answer_of(service, "POST", f"/v1/robots/{quote(robot, safe='')}/breakpoints:{verb}"))


def _words(known: dict[str, Any]) -> str:
    if known["refusal"]:
        return f"no breakpoints: {known['refusal']}"
    rules = f"breakpoints at {', '.join(known['rules'])}" if known["rules"] else "no breakpoints"
    lines = [f"{known['robot']} has {rules}"]
    if known["of_others"]:
        lines.append(f"other robots of {known['world']} have {known['of_others']}")
    if known["ended"]:
        lines.append(known["ended"])
    if not known["halts"]:
        lines.append(f"{known['world']} runs")
    for halt in known["halts"]:
        lines += _halt(halt)
    if known["left_s"] is not None:
        lines.append(f"{known['world']} goes on by itself in {known['left_s']:.0f} s")
    return "\n".join(lines)


def _halt(halt: dict[str, Any]) -> Iterator[str]:
    yield f"{halt['robot']} stands at {halt['at_s']:.2f} s"
    for firing in halt["firings"]:
        bound = "".join(f", ?{name.lstrip('?')} = {value}" for name, value in firing["bindings"].items())
        yield f"  {firing['agent']}: {firing['rule']} fires: {firing['does'] or 'beliefs only'}{bound}"
    for agent in halt["agents"]:
        under_way = [one for one in agent["commitments"] if one["ended_s"] is None]
        for one in under_way:
            yield f"  {agent['name']}: {one['rule']} {one['name']} is {one['state']}"
