"""The production shape without containers: the processes of docker-compose.yml on this machine, from the same settings.

Database and broker are given: MACTA_DATABASE_HOST, …_PORT, …_USER, …_PASSWORD, …_NAME, MACTA_BROKER_URL,
MACTA_SERVICE_PASSWORD, MACTA_FLEET_PASSWORD and MACTA_TOKEN, as docker-compose.yml names them.

    uv run python -m examples.production FOLDER

What dies is begun again, as Compose does.
"""

import argparse
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import yaml

COMPOSE = Path(__file__).parent.parent / "docker-compose.yml"
VARIABLE = re.compile(r"\$(?:\$|\{(\w+)(?::([-?])([^}]*))?\})")
MACTA = [sys.executable, "-c", "from app.cli import main; main()"]
READY = re.compile(r"(?:Macta|The planning worker|The fleet).* is ready.*")
LOOK_S = 1.0
GRACE_S = 20


class Incomplete(Exception):
    """Raised when docker-compose.yml wants a variable that is not set."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A service of docker-compose.yml that is ours: what each of its processes is started with."""

    name: str
    arguments: Sequence[str]
    environment: Mapping[str, str]
    copies: int


@dataclass(slots=True, kw_only=True)
class Running:
    """A process; `said` is what it printed when it was ready."""

    name: str
    process: subprocess.Popen[str]
    said: str = ""
    listener: threading.Thread = field(init=False)
    ready: threading.Event = field(default_factory=threading.Event)


def parts_of(compose: Mapping[str, Any], given: Mapping[str, str]) -> list[Part]:
    """The services that are built here, with their variables filled in.

    :raises Incomplete: naming the variable that is missing.
    """
    return [
        Part(
            name=name,
            arguments=[filled(word, given) for word in service["command"][1:]],
            environment={
                key: value for key, raw in service["environment"].items() if (value := filled(raw, given))
            },
            copies=service["deploy"]["replicas"],
        )
        for name, service in compose["services"].items()
        if "build" in service
    ]


def filled(text: str, given: Mapping[str, str]) -> str:
    """`${NAME}`, `${NAME:-default}` and `${NAME:?complaint}` as Compose replaces them."""

    def value(found: re.Match[str]) -> str:
        name, kind, more = found.groups()
        if name is None:
            return "$"
        if kind == "?" and not given.get(name):
            raise Incomplete(f"{name}: {more}")
        return given.get(name) or (more if kind == "-" else "")

    return VARIABLE.sub(value, text)


class Shape:
    """Every process of every part, with a folder each; one that ends is begun again, as `restart` has it in Compose."""

    def __init__(self, folder: Path, given: Mapping[str, str]) -> None:
        """:raises Incomplete: naming the variable that is missing."""
        parts = parts_of(yaml.safe_load(COMPOSE.read_text()), given)
        self._begin = {
            f"{part.name}-{number}": partial(start, part, number, folder)
            for part in parts
            for number in range(1, part.copies + 1)
        }
        self.running: dict[str, Running] = {}

    def look(self) -> Sequence[Running]:
        """Begin what does not run; answers what was begun."""
        ended = [
            name
            for name in self._begin
            if name not in self.running or self.running[name].process.poll() is not None
        ]
        self.running.update({name: self._begin[name]() for name in ended})
        return [self.running[name] for name in ended]

    def end(self) -> None:
        """In order: by SIGTERM, all at once; who does not end in the time that Compose gives is killed."""
        for running in self.running.values():
            running.process.send_signal(signal.SIGTERM)
        for running in self.running.values():
            try:
                running.process.wait(timeout=GRACE_S)
            except subprocess.TimeoutExpired:
                running.process.kill()
                running.process.wait()
            running.listener.join(timeout=5)


def start(part: Part, number: int, folder: Path) -> Running:
    """One process of the part, with a folder of its own; the API on any free port of loopback."""
    own = ["--data", str(folder / f"{part.name}-{number}")] if part.name != "worker" else []
    own += ["--port", "0"] if part.name == "api" else []
    inherited = {k: v for k, v in os.environ.items() if not k.startswith("MACTA_")}
    process = subprocess.Popen(
        [*MACTA, *_without_data(part.arguments), *own],
        env={**inherited, **part.environment},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    running = Running(name=f"{part.name}-{number}", process=process)
    running.listener = threading.Thread(target=_listen, args=(running,), daemon=True)
    running.listener.start()
    return running


def _without_data(arguments: Sequence[str]) -> list[str]:
    """A container's folder is not this machine's."""
    at = list(arguments).index("--data") if "--data" in arguments else len(arguments)
    return [*arguments[:at], *arguments[at + 2 :]]


def _listen(running: Running) -> None:
    assert running.process.stdout is not None
    with running.process.stdout as lines:
        for line in lines:
            if READY.match(line):
                running.said = line.strip()
                running.ready.set()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path, help="where each process keeps what it keeps")
    try:
        shape = Shape(parser.parse_args().folder, os.environ)
    except Incomplete as missing:
        parser.error(str(missing))
    told: set[int] = set()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        while True:
            shape.look()
            for running in shape.running.values():
                if running.ready.is_set() and running.process.pid not in told:
                    told.add(running.process.pid)
                    print(f"{running.name}: {running.said}", flush=True)
            time.sleep(LOOK_S)
    except KeyboardInterrupt:
        pass
    finally:
        shape.end()


if __name__ == "__main__":
    main()
