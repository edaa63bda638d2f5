"""The virtual vehicle of the package vda-5050-lib as a process, and the adapter that makes it a robot."""

import shutil
import signal
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from robots.adapters.vda5050.master import MasterControl
from robots.adapters.vda5050.settings import Settings, VehicleSettings, places_of_world
from robots.link.mqtt import Broker
from tests.mosquitto import Mosquitto

FOLDER = Path(__file__).parent.parent / "third_party" / "vda5050"
SERIAL = "AGV-7"
LOAD = {"stationType": "floor", "loadType": "EPAL", "duration": 0.5}
"""What this vehicle wants to know of a load."""

needs_node = pytest.mark.skipif(
    shutil.which("node") is None or not (FOLDER / "node_modules").is_dir(),
    reason=f"no node, or not installed: npm install --prefix {FOLDER.relative_to(Path.cwd())}",
)


class VirtualVehicle:
    """The process."""

    def __init__(self, broker: Mosquitto, *, x_m: float = 4, y_m: float = 3, speed_m_s: float = 1) -> None:
        self._process = subprocess.Popen(
            ["node", str(FOLDER / "vehicle.js"), broker.url, SERIAL, str(x_m), str(y_m), str(speed_m_s)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == "ready\n"

    def cut_off(self, is_cut: bool) -> None:
        """It answers nothing more, so that the broker gives it up; or it goes on."""
        self._process.send_signal(signal.SIGSTOP if is_cut else signal.SIGCONT)

    def close(self) -> None:
        self._process.kill()
        self._process.communicate()


@contextmanager
def adapter(
    folder: Path, world: Path, broker: Mosquitto, *, robot: str | None = None
) -> Iterator[MasterControl]:
    """The adapter, as `macta-robot vda5050` runs it.

    :param robot: what the vehicle is called in the world (default: what its serial number makes).
    """
    at = Broker.at(broker.url)
    settings = Settings(
        places=places_of_world(world),
        action_parameters={"pick": LOAD, "drop": LOAD},
        versions=(2,),
        vehicles={f"VirtualWorks/{SERIAL}": VehicleSettings(robot=robot)},
    )
    control = MasterControl(settings, world=world.stem, vehicles_at=at, macta_at=at, folder=folder)
    ends = threading.Event()
    runs = threading.Thread(target=control.run, args=(ends,))
    control.start()
    runs.start()
    try:
        yield control
    finally:
        ends.set()
        runs.join()
        control.close()
