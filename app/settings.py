"""Settings: from the environment (`MACTA_…`) and the command line."""

import fcntl
import logging
import os
import re
import secrets
import stat
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TextIO

from pydantic import Field, SecretStr, field_validator
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

from app.database_url import DatabaseUrl
from app.domain.errors import Invalid, Unavailable
from app.packs import STORE, split_names

if TYPE_CHECKING:
    from robots.link.mqtt import Broker
    from robots.link.transport import Transport

MIN_TOKEN_LENGTH = 16


class Settings(BaseSettings):
    """Settings of an installation. By default everything runs embedded in the data folder, on loopback."""

    model_config = SettingsConfigDict(env_prefix="MACTA_")

    data: Path = Path("macta-data")
    host: str = "127.0.0.1"
    port: int = Field(default=8000, ge=0, le=65535)
    database_url: str | None = None
    token: str | None = Field(default=None, min_length=MIN_TOKEN_LENGTH)
    planning_time_limit_s: float = Field(default=30.0, gt=0, description="default for goals")
    planning_longest_s: float = Field(default=600.0, gt=0, description="maximum for goals")
    planning_effort_s: float | None = Field(
        default=None, ge=0, description="time to improve a first plan (default: by the problem's size)"
    )
    planning_memory_mb: int = Field(default=2048, ge=64)
    planning_processes: int = Field(
        default=2,
        ge=0,
        le=64,
        description="goals planned in parallel; 0: planning is left to `macta worker`",
    )
    answer_patience_s: float = Field(
        default=10.0, gt=0, description="wall-clock seconds before a robot is silent"
    )
    margin_relative: float = Field(default=0.5, ge=0)
    margin_s: float = Field(default=20.0, ge=0)
    open_goals: int = Field(
        default=2000, ge=1, description="maximum of open goals; further ones are refused for now"
    )
    worlds: int = Field(
        default=16, ge=1, description="maximum of worlds; further ones are not added while the service runs"
    )
    open_streams: int = Field(default=500, ge=1, description="maximum of clients that follow a stream")
    connections: int = Field(
        default=2000, ge=1, description="maximum of open connections, with and without a token"
    )
    connections_per_address: int = Field(
        default=1000, ge=1, description="likewise from one address, such as a reverse proxy's"
    )
    header_timeout_s: float = Field(
        default=10.0, gt=0, description="for a request's header; also for a connection's first request"
    )
    body_timeout_s: float = Field(default=60.0, gt=0, description="for a request's body, after its header")
    keep_days: float = Field(
        default=30.0,
        gt=0,
        description="retention of events, robots' messages and finished workflows",
    )
    keep_goals_days: float = Field(
        default=365.0,
        gt=0,
        description="retention of finished goals with their plans, missions and scripts",
    )
    keep_events: int = Field(default=1_000_000, ge=1000, description="maximum of kept events")
    recordings_mb: int = Field(
        default=1000,
        ge=0,
        description="maximum size of all recordings; the oldest are deleted first; 0: none are made",
    )
    low_battery: float = Field(
        default=0.2, ge=0, le=1, description="battery level, 0 to 1, below which a robot is not recruited"
    )

    joint_goals: int = Field(
        default=4, ge=1, description="most waiting goals that are planned together; 1: each by itself"
    )

    admission: Literal["operator", "all"] = Field(
        default="operator", description="who admits robots that announce themselves and are in no world"
    )

    packs: Annotated[tuple[str, ...], NoDecode] = Field(
        default=(STORE,), description="domain packs, by name or folder, separated by commas"
    )

    broker_url: str | None = Field(
        default=None, description="MQTT broker of the robots (default: the world is embedded)"
    )
    broker_username: str | None = None
    broker_password: SecretStr | None = None
    broker_ca: Path | None = Field(default=None, description="certificate authority of the broker, PEM")
    broker_certificate: Path | None = Field(default=None, description="client certificate, PEM")
    broker_key: Path | None = None
    robot_keys: Path | None = Field(
        default=None,
        description="file of the keys with which robots sign, as `macta robot enrol --sign` writes it",
    )

    @field_validator(
        "broker_url",
        "broker_username",
        "broker_password",
        "broker_ca",
        "broker_certificate",
        "broker_key",
        "robot_keys",
        mode="before",
    )
    @classmethod
    def _unset(cls, value: object) -> object:
        """Treat an empty variable as unset, for Compose passes unset variables as empty."""
        return None if value == "" else value

    @field_validator("packs", mode="before")
    @classmethod
    def _pack_names(cls, value: object) -> object:
        return (split_names(value) or (STORE,)) if isinstance(value, str) else value

    @field_validator("database_url")
    @classmethod
    def _usable_database(cls, url: str | None) -> str | None:
        """:raises ValueError: if it is not supported; the message omits the URL, which may contain a password."""
        if not url:
            return None
        DatabaseUrl.of(url)
        return url

    def broker(self) -> "Broker | Transport | None":
        """The MQTT broker, or a package's link to the robots; None if the world is embedded.

        :raises Invalid: if address or credentials cannot be used.
        """
        if self.broker_url is None:
            return None
        # Imported here: an embedded service does not need it.
        from robots.link.mqtt import Broker
        from robots.link.mqtt.broker import PORTS

        try:
            if (scheme := self.broker_url.partition("://")[0]) not in PORTS:
                from robots.link.transport import package_schemes, package_transport

                if (transport := package_transport(self.broker_url)) is not None:
                    return transport
                if others := package_schemes():
                    raise ValueError(f"no link for {scheme}://; choices: {', '.join((*PORTS, *others))}")
            return Broker.at(
                self.broker_url,
                username=self.broker_username,
                password=self.broker_password,
                ca=self.broker_ca,
                certificate=self.broker_certificate,
                key=self.broker_key,
            )
        except ValueError as error:
            raise Invalid(f"MACTA_BROKER_URL: {error}") from error

    def resolved_database_url(self) -> str:
        return self.database_url or f"sqlite:///{self.data / 'macta.sqlite'}"

    @property
    def database_is_shared(self) -> bool:
        """True if other processes may use the database, too."""
        return not self.resolved_database_url().startswith("sqlite")

    @property
    def database_location(self) -> str:
        """Where the database is, for people; without the password."""
        if not self.database_is_shared:
            return str(self.data)
        url = DatabaseUrl.of(self.resolved_database_url())
        return f"database {url.database} on {url.host}"

    def resolved_token(self) -> str:
        """The administrator's token: from the environment, else from the data folder, else a new one stored there."""
        if self.token is not None:
            return self.token
        if self.database_is_shared:
            raise Invalid(
                "set MACTA_TOKEN: other processes on MACTA_DATABASE_URL would not have a token generated here",
                code="token-needed",
            )
        path = self.data / "token"
        return _read_token(path) if path.exists() else _write_token(path)


def _read_token(path: Path) -> str:
    """:raises Invalid: if the file holds no token, for example because the disk was full when it was written."""
    try:
        token = path.read_text(errors="replace").strip()
    except OSError as error:
        raise Invalid(f"the token cannot be read from {path}: {error.strerror}") from error
    if not re.fullmatch(rf"[!-~]{{{MIN_TOKEN_LENGTH},}}", token):
        raise Invalid(
            f"{path} holds no token of at least {MIN_TOKEN_LENGTH} printable characters (was the disk full?); "
            "delete the file; the next start generates a new token",
            code="token-damaged",
        )
    return token


def _write_token(path: Path) -> str:
    """Generate a token and write its file atomically.

    :raises Unavailable: if it cannot be written.
    """
    token = secrets.token_urlsafe(32)
    unfinished = path.with_suffix(".unfinished")
    try:
        with os.fdopen(os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "w") as file:
            file.write(token + "\n")
            file.flush()
            os.fsync(file.fileno())
        unfinished.replace(path)
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise Unavailable(f"the token cannot be written to {path}: {error.strerror}") from error
    return token


def make_folder(data: Path) -> None:
    """Create the data folder, or close an existing one to other users: it holds the record and the token.

    A folder of another owner, or a shared one like `/tmp`, is not changed, with a warning.
    """
    data.mkdir(parents=True, exist_ok=True, mode=0o700)
    status = data.stat()
    if not status.st_mode & 0o077:
        return
    if status.st_uid == os.geteuid() and not status.st_mode & stat.S_ISVTX:
        data.chmod(0o700)
    else:
        logging.getLogger(__name__).warning(
            "other users may have access to the data folder %s: choose a private one with --data", data
        )


def lock_folder(data: Path) -> TextIO:
    """Create the data folder and lock it for this process until the returned file is closed.

    :raises Unavailable: if another service works in it.
    """
    make_folder(data)
    lock = (data / "lock").open("w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        lock.close()
        raise Unavailable(
            f"another service uses the data folder {data}; end it, or choose another folder with --data"
        ) from error
    return lock
