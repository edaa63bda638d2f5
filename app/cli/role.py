"""`macta robot role`: shows, gives and ends a robot's role, on a running service."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from app.cli.service_calls import answer_of
from app.domain.errors import Invalid

if TYPE_CHECKING:
    from httpx2 import Client


def role(
    service: "Client",
    robot: str,
    wanted: str | None,
    *,
    tags: Sequence[str] = (),
    home: str | None = None,
    rules: Path | None = None,
    clear: bool = False,
) -> str:
    """Give the robot a role, or end it; says what it plays then.

    :param wanted: None: only say what it plays now.
    :raises Invalid: if the service refuses, with its reason, or a file cannot be read.
    """
    path = f"/v1/robots/{quote(robot, safe='')}/role"
    if clear:
        if wanted is not None:
            raise Invalid("give a role, or --clear to end it")
        return _words(answer_of(service, "DELETE", path))
    if wanted is None:
        if tags or home or rules:
            raise Invalid("name the role that has these tags, home or rules")
        return _words(answer_of(service, "GET", path))
    body: dict[str, Any] = {"role": wanted, "tags": list(tags) or None, "home": home}
    if rules is not None:
        try:
            body["rules"] = rules.read_text(encoding="utf-8")
        except (OSError, ValueError) as error:
            raise Invalid(f"--rules: {rules}: {error}") from error
    return _words(answer_of(service, "PUT", path, body))


def _words(role: dict[str, Any]) -> str:
    robot = role["robot"]
    kept = f"; its home stays: {role['home_kept']}" if role["home_kept"] else ""
    if role["role"] is None:
        return f"{robot} plays no role{kept}"
    parts = [f"{robot} plays {role['role']}"]
    if role["tags"] is not None:
        parts.append(f"recruited for {', '.join(role['tags']) or 'nothing'}")
    if role["home"] is not None:
        parts.append(f"home {role['home']}")
    detail = f": {role['detail']}" if role["detail"] else ""
    return f"{'; '.join(parts)}; rules {role['delivery']}{detail}{kept}"
