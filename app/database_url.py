"""The address of the record's database, read as SQLAlchemy reads it, which most commands do without."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self
from urllib.parse import parse_qs, unquote

FORMS = "postgresql://USER:PASSWORD@HOST:PORT/DATABASE or sqlite:////FOLDER/FILE"
POSTGRESQL = ("postgresql", "postgresql+psycopg")
SQLITE = ("sqlite", "sqlite+pysqlite")


@dataclass(frozen=True, slots=True, kw_only=True)
class DatabaseUrl:
    """The parts of an address; None or empty where it names none.

    :param options: all values of each option after the question mark.
    """

    is_shared: bool
    user: str | None
    password: str | None
    host: str | None
    port: int | None
    database: str | None
    options: Mapping[str, list[str]]

    @classmethod
    def of(cls, url: str) -> Self:
        """:raises ValueError: if it is not supported; the message omits the URL, which may contain a password."""
        kind, separator, rest = url.partition("://")
        if not separator:
            raise ValueError(f"not of the form {FORMS}")
        if kind not in (*POSTGRESQL, *SQLITE):
            raise ValueError(f"{kind} is not supported; give {FORMS}")
        credentials, has_user, place = rest.partition("@")
        user, has_password, password = credentials.partition(":")
        if not has_user or "/" in user:  # the @ is part of an option
            has_user = has_password = ""
            place = rest
        address, _, options = place.partition("?")
        server, _, database = address.partition("/")
        host, port = _host_and_port(server)
        read = cls(
            is_shared=kind in POSTGRESQL,
            user=unquote(user) if has_user else None,
            password=unquote(password) if has_password else None,
            host=host or None,
            port=port,
            database=unquote(database) or None,
            options=parse_qs(options),
        )
        if not read.is_shared and read.database in {None, ":memory:"}:
            raise ValueError(f"names no database file; give {FORMS}")
        return read

    def server_parameters(self) -> dict[str, str]:
        """The parameters of a connection to the server, by libpq's names."""
        own = {
            "user": self.user,
            "password": self.password,
            "host": self.host,
            "port": None if self.port is None else str(self.port),
            "dbname": self.database,
        }
        given = {name: ",".join(values) for name, values in self.options.items()}
        if hosts := self.options.get("host"):
            given |= _several(hosts)
        return {name: value for name, value in own.items() if value} | given


def _host_and_port(server: str) -> tuple[str, int | None]:
    """:raises ValueError: if the port is no number."""
    if server.startswith("["):
        host, _, port = server[1:].partition("]")
        port = port.removeprefix(":")
    else:
        host, _, port = server.partition(":")
    if port and not (port.isascii() and port.isdigit()):
        raise ValueError(f"not of the form {FORMS}: the port is no number")
    return host, int(port) if port else None


def _several(hosts: list[str]) -> dict[str, str]:
    """`host=a:1&host=b:2` as libpq's two lists; a folder of sockets has no port."""
    pairs = [(host, "", "") if host.startswith("/") else host.partition(":") for host in hosts]
    ports = [port for _, _, port in pairs]
    return {"host": ",".join(host for host, _, _ in pairs)} | (
        {"port": ",".join(ports)} if any(ports) else {}
    )
