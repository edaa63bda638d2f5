"""Settings: from the environment (`MACTA_…`) and the command line."""

import fcntl
import os
import secrets
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from pydantic import Field, SecretStr, field_validator
from pydantic_settings import BaseSettings, SettingsConfigDict
from sqlalchemy import make_url

from app.domain.errors import Invalid, Unavailable

if TYPE_CHECKING:
    from robots.link.mqtt import Broker


class Settings(BaseSettings):
    """Settings of an installation. By default everything runs embedded in the data folder, on loopback."""

    model_config = SettingsConfigDict(env_prefix="MACTA_")

    data: Path = Path("macta-data")
    host: str = "127.0.0.1"
    port: int = Field(default=8000, ge=0, le=65535)
    database_url: str | None = None
    token: str | None = Field(default=None, min_length=16)
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
    open_streams: int = Field(default=500, ge=1, description="maximum of clients that follow a stream")
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

    broker_url: str | None = Field(
        default=None, description="MQTT broker of the robots (default: the world is embedded)"
    )
    broker_username: str | None = None
    broker_password: SecretStr | None = None
    broker_ca: Path | None = Field(default=None, description="certificate authority of the broker, PEM")
    broker_certificate: Path | None = Field(default=None, description="client certificate, PEM")
    broker_key: Path | None = None

    @field_validator(
        "broker_url",
        "broker_username",
        "broker_password",
        "broker_ca",
        "broker_certificate",
        "broker_key",
        mode="before",
    )
    @classmethod
    def _unset(cls, value: object) -> object:
        """Treat an empty variable as unset, for Compose passes unset variables as empty."""
        return None if value == "" else value

    def broker(self) -> "Broker | None":
        """The MQTT broker; None if the world is embedded.

        :raises Invalid: if address or credentials cannot be used.
        """
        if self.broker_url is None:
            return None
        # Imported here, for an embedded service does not need it.
        from robots.link.mqtt import Broker, BrokerError

        try:
            return Broker.at(
                self.broker_url,
                username=self.broker_username,
                password=self.broker_password,
                ca=self.broker_ca,
                certificate=self.broker_certificate,
                key=self.broker_key,
            )
        except BrokerError as error:
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
        url = make_url(self.resolved_database_url())
        return f"database {url.database} on {url.host}" if self.database_is_shared else str(self.data)

    def resolved_token(self) -> str:
        """The administrator's token: from the environment, else from the data folder, else a new one stored there."""
        if self.token is not None:
            return self.token
        if self.database_is_shared:
            raise Invalid(
                "set MACTA_TOKEN: other processes on MACTA_DATABASE_URL would not know a token generated here",
                code="token-needed",
            )
        path = self.data / "token"
        if path.is_file():
            return path.read_text().strip()
        token = secrets.token_urlsafe(32)
        with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(token + "\n")
        return token


def lock_folder(data: Path) -> TextIO:
    """Create the data folder and lock it for this process until the returned file is closed.

    :raises Unavailable: if another service works in it.
    """
    data.mkdir(parents=True, exist_ok=True, mode=0o700)
    lock = (data / "lock").open("w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        lock.close()
        raise Unavailable(
            f"another service works in {data}; end it, or choose another data folder"
        ) from error
    return lock
