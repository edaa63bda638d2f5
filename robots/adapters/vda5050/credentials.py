"""A broker's user for each vehicle: files as `macta robot enrol NAME --out FOLDER/NAME.env` writes them."""

from pathlib import Path

from pydantic import SecretStr

from robots.errors import RobotError
from robots.link.mqtt import Broker

SUFFIX = ".env"


class CredentialsError(RobotError):
    """Raised when a robot's credentials are missing or cannot be used; names the file and the way out, no secret."""


def broker_of(robot: str, broker: Broker, folder: Path) -> Broker:
    """The broker with a robot's own credentials.

    :raises CredentialsError: if the folder has no file of the robot, or it cannot be used.
    """
    path = folder / f"{robot}{SUFFIX}"
    given = _read(robot, path)
    if not {"MACTA_BROKER_PASSWORD", "MACTA_BROKER_CERTIFICATE"} & given.keys():
        raise CredentialsError(
            f"{path} has neither password nor certificate: macta robot enrol {robot} --renew --out {path}"
        )
    password = given.get("MACTA_BROKER_PASSWORD")
    return Broker.at(
        str(broker),
        username=given.get("MACTA_BROKER_USERNAME"),
        password=None if password is None else SecretStr(password),
        ca=_path(given.get("MACTA_BROKER_CA")),
        certificate=_path(given.get("MACTA_BROKER_CERTIFICATE")),
        key=_path(given.get("MACTA_BROKER_KEY")),
    )


def key_of(robot: str, folder: Path) -> str | None:
    """The robot's key for signatures; None if it was enrolled without.

    :raises CredentialsError: if the folder has no file of the robot, or it cannot be read.
    """
    return _read(robot, folder / f"{robot}{SUFFIX}").get("MACTA_ROBOT_KEY") or None


def _read(robot: str, path: Path) -> dict[str, str]:
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError as error:
        raise CredentialsError(
            f"{path} is missing: make it by macta robot enrol {robot} --out {path}"
        ) from error
    except (OSError, UnicodeDecodeError) as error:
        raise CredentialsError(f"{path} cannot be read: {error}") from error
    return {name.strip(): value.strip() for name, _, value in (line.partition("=") for line in lines)}


def _path(text: str | None) -> Path | None:
    return Path(text) if text else None
