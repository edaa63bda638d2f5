"""The broker's password file and access list: who is enrolled, and what each may publish and read.

Mosquitto reads both at its start and on SIGHUP. Lines that are not of an enrolled robot are kept as they are.
"""

import base64
import fcntl
import hashlib
import json
import os
import re
import secrets
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from app.domain.errors import Conflict, Invalid, NotFound
from robots.link.mqtt.topics import Channel, robot_topic, speech_topic, world_topic

PASSWORDS = "passwords"
ACCESS = "acl"
KEYS = "robot_keys.json"
LOCK = ".enrolment.lock"
BEGIN = "# begin of robots enrolled by `macta robot enrol`; do not edit"
END = "# end of robots enrolled by `macta robot enrol`"
NAME = re.compile(r"[a-z][a-z0-9_]{0,63}")
PATTERNS = re.compile(r"^pattern .*%u", re.MULTILINE)
RESERVED = frozenset({"service", "fleet"})
"""Users of the broker that are no robots."""
ANY_WORLD = "+"
ANY_ROBOT = "+"
SALT_BYTES = 12
ITERATIONS = 1000
"""Of PBKDF2. The secrets are random: more would only delay the broker (our choice)."""
SECRET_BYTES = 32
READS = (Channel.ORDER, Channel.INSTANT_ACTIONS)
WRITES = (Channel.CONNECTION, Channel.STATE, Channel.VISUALIZATION, Channel.FACTSHEET)


def service_and_fleet() -> str:
    """The access list that a folder without one gets: the rights of the users `service` and `fleet`."""
    of_robots = [robot_topic("+", "+", channel) for channel in WRITES]
    to_robots = [robot_topic("+", "+", channel) for channel in READS]
    lines = [
        "# Who may publish and read what at the broker. A user that is not named, and a topic that is not allowed,",
        "# is refused.",
        "",
        "user service",
        f"topic readwrite {world_topic('+')}",  # it announces worlds without a fleet
        *(f"topic read {topic}" for topic in of_robots),
        *(f"topic write {topic}" for topic in to_robots),
        "",
        "user fleet",
        f"topic readwrite {world_topic('+')}",
        *(f"topic read {topic}" for topic in to_robots),
        *(f"topic write {topic}" for topic in of_robots),
        f"topic readwrite {speech_topic('+', ANY_ROBOT, ANY_ROBOT)}",
    ]
    return "\n".join(lines) + "\n"


@dataclass(frozen=True, slots=True, kw_only=True)
class Enrolled:
    """A robot with rights at the broker. `world`: the only one that it is let into; "+" for all."""

    name: str
    world: str
    has_password: bool
    signs: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Secrets:
    """What the robot is given, once. An empty one it has already, or does without."""

    password: str = ""
    key: str = ""


class BrokerFiles:
    """The two files of a folder, and the keys with which robots sign. Every change is atomic for the broker."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def enrolled(self) -> Sequence[Enrolled]:
        """The robots that are enrolled, by name."""
        passwords = _users(self._read(PASSWORDS))
        keys = self._keys()
        return sorted(
            (
                Enrolled(name=name, world=world, has_password=name in passwords, signs=name in keys)
                for name, world in _blocks(self._read(ACCESS)).items()
            ),
            key=lambda one: one.name,
        )

    def enrol(
        self, name: str, *, world: str | None, password: bool = True, signs: bool = False, renew: bool = False
    ) -> Secrets:
        """Give a robot its rights, and the secrets that it lacks. Again without effect.

        :param world: the only one that it is let into; None: all, or that of its enrolment.
        :param password: False for a robot that shows a certificate instead.
        :param signs: it signs its messages. :param renew: it gets new secrets for those that it has.
        :raises Invalid: if a name is none, or is the broker's own.
        :raises Conflict: if the access list has rights of this name that are not ours.
        """
        check_names(name, world)
        with self._locked():
            before = _blocks(self._read(ACCESS))
            self._refuse_foreign(name, world, before)
            kept = self._read(PASSWORDS)
            keys = dict(self._keys())
            needs_password = password and (renew or name not in _users(kept))
            needs_key = (signs or name in keys) and (renew or name not in keys)
            made = Secrets(
                password=secrets.token_urlsafe(SECRET_BYTES) if needs_password else "",
                key=secrets.token_urlsafe(SECRET_BYTES) if needs_key else "",
            )
            if made.key:
                self._write(KEYS, json.dumps(keys | {name: made.key}, indent=2, sort_keys=True) + "\n")
            if made.password:
                self._write(PASSWORDS, _without_user(kept, name) + f"{name}:{digest(made.password)}\n")
            after = {**before, name: world or before.get(name, ANY_WORLD)}
            if after != before or not self._path(ACCESS).exists():
                self._write(ACCESS, _with_blocks(self._read(ACCESS) or service_and_fleet(), after))
        return made

    def revoke(self, name: str) -> None:
        """Take all rights and secrets of a robot.

        :raises NotFound: if it is not enrolled.
        """
        with self._locked():
            before = _blocks(self._read(ACCESS))
            if name not in before:
                raise NotFound(
                    f"no robot {name!r} is enrolled in {self.folder}",
                    code="not-enrolled",
                    choices=sorted(before),
                )
            # The rights first: without them the password is worth nothing.
            rest = {other: world for other, world in before.items() if other != name}
            self._write(ACCESS, _with_blocks(self._read(ACCESS), rest))
            self._write(PASSWORDS, _without_user(self._read(PASSWORDS), name))
            if name in (keys := dict(self._keys())):
                del keys[name]
                self._write(KEYS, json.dumps(keys, indent=2, sort_keys=True) + "\n")

    def _refuse_foreign(self, name: str, world: str | None, enrolled: Mapping[str, str]) -> None:
        access = _without_blocks(self._read(ACCESS))
        if re.search(rf"^user {name}$", access, re.MULTILINE):
            raise Conflict(
                f"{self._path(ACCESS)} has a `user {name}` that was not enrolled; remove it first",
                code="user-exists",
                thing=name,
            )
        if world is not None and PATTERNS.search(access):
            raise Conflict(
                f"{self._path(ACCESS)} gives every user the topics of its name in all worlds (`pattern` lines); remove "
                f"them to restrict {name} to {world}",
                code="access-not-restricted",
                thing=name,
            )
        if name not in enrolled and name in _users(self._read(PASSWORDS)):
            raise Conflict(
                f"{self._path(PASSWORDS)} has a user {name} that was not enrolled; remove its line first",
                code="user-exists",
                thing=name,
            )

    def _keys(self) -> Mapping[str, str]:
        text = self._read(KEYS)
        return read_keys(text, self._path(KEYS)) if text else {}

    def _path(self, name: str) -> Path:
        return self.folder / name

    def _read(self, name: str) -> str:
        """The file's text; empty if there is none."""
        try:
            return self._path(name).read_text(encoding="utf-8")
        except FileNotFoundError:
            return ""
        except (OSError, UnicodeDecodeError) as error:
            raise Invalid(f"{self._path(name)} cannot be read: {error}", code="broker-files") from error

    def _write(self, name: str, text: str) -> None:
        write_secret(self._path(name), text, keeps_owner=True)

    @property
    def lets_everybody_in_by_name(self) -> bool:
        """True if the access list gives every user the topics of its own name, enrolled or not."""
        return PATTERNS.search(self._read(ACCESS)) is not None

    @contextmanager
    def _locked(self) -> Iterator[None]:
        """One enrolment at a time."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            lock = os.open(self.folder / LOCK, os.O_RDWR | os.O_CREAT, 0o600)
        except OSError as error:
            raise Invalid(
                f"{self.folder} cannot be written: {error.strerror}", code="broker-files"
            ) from error
        try:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield
        finally:
            os.close(lock)


def digest(password: str, *, salt: bytes | None = None) -> str:
    """A password as Mosquitto stores it: `$7$`, iterations, salt and PBKDF2-HMAC-SHA512, both in base64."""
    salt = salt or secrets.token_bytes(SALT_BYTES)
    hashed = hashlib.pbkdf2_hmac("sha512", password.encode(), salt, ITERATIONS)
    return f"$7${ITERATIONS}${base64.b64encode(salt).decode()}${base64.b64encode(hashed).decode()}"


def read_keys(text: str, path: Path) -> Mapping[str, str]:
    """The keys by robot.

    :raises Invalid: if the file holds anything else.
    """
    try:
        keys = json.loads(text)
    except json.JSONDecodeError as error:
        raise Invalid(f"{path} is no file of robots' keys: {error}", code="robot-keys") from error
    if not isinstance(keys, dict) or not all(isinstance(key, str) and key for key in keys.values()):
        raise Invalid(
            f'{path} is no file of robots\' keys: it must be {{"robot": "key", …}}', code="robot-keys"
        )
    return keys


def write_secret(path: Path, text: str, *, keeps_owner: bool = False) -> None:
    """Replace a file at once, readable by its owner only.

    :param keeps_owner: one that exists keeps its owner and permissions.
    :raises Invalid: if it cannot be written.
    """
    # NOTE: the broker reads it as its own user, also on SIGHUP: a new owner would lock it out.
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(6)}")
    try:
        handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        if keeps_owner and path.exists():
            known = path.stat()
            os.chmod(temporary, known.st_mode & 0o777)
            with suppress(PermissionError):
                os.chown(temporary, known.st_uid, known.st_gid)
        os.replace(temporary, path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise Invalid(f"{path} cannot be written: {error.strerror}", code="broker-files") from error


def check_names(name: str, world: str | None) -> None:
    """:raises Invalid: if a name is none, or is the broker's own."""
    for what, given in (("robot", name), ("world", world)):
        if given is not None and NAME.fullmatch(given) is None:
            raise Invalid(
                f"{given!r} is no {what}'s name: small letters, digits and _, a letter first, at most 64",
                code="not-a-name",
                thing=given,
            )
    if name in RESERVED:
        raise Invalid(f"no robot may be named {name}", code="name-reserved", thing=name)


def _users(passwords: str) -> frozenset[str]:
    return frozenset(line.partition(":")[0] for line in passwords.splitlines() if ":" in line)


def _without_user(passwords: str, name: str) -> str:
    lines = passwords.splitlines(keepends=True)
    kept = "".join(line for line in lines if line.partition(":")[0] != name)
    return kept if not kept or kept.endswith("\n") else f"{kept}\n"


def _blocks(access: str) -> dict[str, str]:
    """The enrolled robots and their worlds."""
    inside = access.partition(BEGIN)[2].partition(END)[0]
    robots: dict[str, str] = {}
    for line in inside.splitlines():
        if line.startswith("user "):
            robots[line.removeprefix("user ")] = ANY_WORLD
        elif line.startswith("topic write "):
            parts = line.split("/")
            robots[parts[3]] = parts[2]
    return robots


def _without_blocks(access: str) -> str:
    before, begin, rest = access.partition(BEGIN)
    return before + rest.partition(END)[2].lstrip("\n") if begin else access


def _with_blocks(access: str, robots: Mapping[str, str]) -> str:
    """The access list with these robots, before everything that applies to every user."""
    others = _without_blocks(access)
    patterns = re.search(r"(^#.*\n)*^pattern ", others, re.MULTILINE)
    at = patterns.start() if patterns else len(others)
    head = others[:at].rstrip("\n")
    tail = others[at:]
    blocks = "".join(f"\n{_block(name, world)}" for name, world in sorted(robots.items()))
    return f"{head}\n\n{BEGIN}\n{blocks}\n{END}\n" + (f"\n{tail}" if tail else "")


def _block(name: str, world: str) -> str:
    rights = [f"user {name}", f"topic read {world_topic(world)}"]
    rights += [f"topic read {robot_topic(world, name, channel)}" for channel in READS]
    rights += [f"topic write {robot_topic(world, name, channel)}" for channel in WRITES]
    rights.append(f"topic write {speech_topic(world, name, ANY_ROBOT)}")
    rights.append(f"topic read {speech_topic(world, ANY_ROBOT, name)}")
    return "\n".join(rights) + "\n"
