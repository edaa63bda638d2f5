"""The broker's address and credentials. Its text form, `mqtts://host:8883`, holds no secrets."""

import ssl
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path
from urllib.parse import urlsplit

from pydantic import SecretStr

PORTS = {"mqtt": 1883, "mqtts": 8883}


class BrokerError(ValueError):
    """Raised when a broker's address or credentials are not valid; the message holds no secrets."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Broker:
    """An MQTT 5 broker. `tls`: the certificate is checked against `ca`, or the system's authorities; None: no TLS.

    `has_certificate`: the client has one, too.
    """

    host: str
    port: int
    username: str | None = None
    password: SecretStr | None = None
    tls: ssl.SSLContext | None = None
    has_certificate: bool = False

    @classmethod
    def at(
        cls,
        url: str,
        *,
        username: str | None = None,
        password: SecretStr | None = None,
        ca: Path | None = None,
        certificate: Path | None = None,
        key: Path | None = None,
    ) -> "Broker":
        """
        :param url: `mqtt://HOST[:PORT]`, or `mqtts://HOST[:PORT]` for TLS.
        :param certificate: the client's own, with `key`, where the broker asks for one.
        :raises BrokerError: naming what is wrong.
        """
        scheme, host, port = _parsed(url)
        if password is not None and username is None:
            raise BrokerError("a broker's password needs a user name, too")
        if scheme == "mqtt" and (ca or certificate or key):
            raise BrokerError(f"certificates need TLS: say mqtts://{host}, not mqtt://{host}")
        tls = _context(ca, certificate, key) if scheme == "mqtts" else None
        return cls(
            host=host,
            port=port,
            username=username,
            password=password,
            tls=tls,
            has_certificate=certificate is not None,
        )

    @property
    def is_private(self) -> bool:
        """False if messages and password can be read on the network."""
        return self.tls is not None or self.is_on_loopback

    @property
    def is_anonymous(self) -> bool:
        """True if clients do not authenticate themselves, so that the broker accepts any."""
        return self.username is None and not self.has_certificate

    @property
    def is_on_loopback(self) -> bool:
        """True if only this machine reaches it."""
        try:
            return ip_address(self.host).is_loopback
        except ValueError:
            return self.host == "localhost"

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{'mqtts' if self.tls else 'mqtt'}://{host}:{self.port}"


def _parsed(url: str) -> tuple[str, str, int]:
    example = "say mqtt://HOST[:PORT] or mqtts://HOST[:PORT]"
    try:
        parts = urlsplit(url)
        host = parts.hostname
        port = parts.port
    except ValueError as error:
        raise BrokerError(f"the broker's address cannot be read; {example}") from error
    if parts.username is not None or parts.password is not None:
        # NOTE: the message must not repeat the address: it holds the secret.
        raise BrokerError(
            "credentials do not belong into the broker's address; say MACTA_BROKER_USERNAME and MACTA_BROKER_PASSWORD"
        )
    if parts.scheme not in PORTS or not host or parts.path.strip("/") or parts.query or port == 0:
        raise BrokerError(f"{url!r} is not a broker's address; {example}")
    return parts.scheme, host, port or PORTS[parts.scheme]


def _context(ca: Path | None, certificate: Path | None, key: Path | None) -> ssl.SSLContext:
    if (certificate is None) != (key is None):
        raise BrokerError("a client certificate and its key come together")
    try:
        context = ssl.create_default_context(cafile=ca)
    except (OSError, ssl.SSLError) as error:
        raise BrokerError(f"the authority's certificate {ca} cannot be used: {error}") from error
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    if certificate is not None:
        try:
            context.load_cert_chain(certificate, key)
        except (OSError, ssl.SSLError) as error:
            raise BrokerError(f"the client certificate {certificate} cannot be used: {error}") from error
    return context
