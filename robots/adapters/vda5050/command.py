"""Connect VDA 5050 vehicles to Macta as robots of a world: the master control of all vehicles on a broker.

With --vehicle the other way round: robots of a world without a service become vehicles of another master control.

Credentials: MACTA_BROKER_USERNAME and MACTA_BROKER_PASSWORD for Macta's broker, VDA5050_BROKER_USERNAME and
VDA5050_BROKER_PASSWORD for the vehicles', if that is another one. With --credentials each vehicle is a user of its own.
"""

import argparse
import logging
import os
import signal
import sys
import threading
from pathlib import Path

from pydantic import SecretStr

from robots.adapters.vda5050.foreign_master import ForeignMaster
from robots.adapters.vda5050.master import TICK_S, MasterControl
from robots.adapters.vda5050.settings import load_settings
from robots.errors import RobotError
from robots.link.mqtt import Broker, BrokerError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--world", required=True, help="the world whose robots the vehicles become")
    parser.add_argument("--broker", required=True, help="Macta's broker, mqtt://HOST[:PORT] or mqtts://…")
    parser.add_argument("--vda5050-broker", help="the vehicles' broker (default: Macta's)")
    parser.add_argument("--settings", type=Path, help="YAML file (docs/vda5050.md)")
    parser.add_argument("--world-file", type=Path, help="a world file, for the poses of its places")
    parser.add_argument(
        "--memory",
        type=Path,
        default=Path("macta-vda5050"),
        help="folder for what must outlive a restart (default: %(default)s)",
    )
    parser.add_argument(
        "--vehicle",
        action="append",
        metavar="ROBOT",
        help="a robot that becomes a vehicle of another master control; repeatable",
    )
    parser.add_argument(
        "--credentials",
        type=Path,
        metavar="FOLDER",
        help="each vehicle's own at Macta's broker: files NAME.env, made by macta robot enrol NAME --out",
    )
    parser.add_argument("--ca", type=Path, help="the authority's certificate, for mqtts://")
    parser.add_argument("-v", "--verbose", action="store_true", help="log what is found and done")


def run(arguments: argparse.Namespace) -> int:
    """Run until interrupted; the exit status."""
    logging.basicConfig(
        level=logging.INFO if arguments.verbose else logging.WARNING, format="%(levelname)s %(message)s"
    )
    try:
        settings = load_settings(arguments.settings, world_file=arguments.world_file)
        macta_at = _broker(arguments.broker, "MACTA", arguments.ca)
        vehicles_at = macta_at
        if arguments.vda5050_broker is not None:
            vehicles_at = _broker(arguments.vda5050_broker, "VDA5050", arguments.ca)
        control: MasterControl | ForeignMaster
        ends = {"world": arguments.world, "vehicles_at": vehicles_at, "macta_at": macta_at}
        if arguments.vehicle:
            control = ForeignMaster(settings, arguments.vehicle, folder=arguments.memory, **ends)
        else:
            control = MasterControl(
                settings, folder=arguments.memory, credentials=arguments.credentials, **ends
            )
        if not settings.places:
            logging.warning("no places are known: give --world-file or `places`, or no packet can be driven")
        _serve(control)
    except (RobotError, BrokerError, OSError) as error:
        sys.stderr.write(f"macta-robot vda5050: {error}\n")
        return 2
    return 0


def _serve(control: MasterControl | ForeignMaster) -> None:
    ends = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ends.set())
    control.start()
    try:
        while not ends.wait(TICK_S):
            control.tick()
    finally:
        control.close()


def _broker(url: str, prefix: str, ca: Path | None) -> Broker:
    """The broker at an address, with the credentials of the environment."""
    password = os.environ.get(f"{prefix}_BROKER_PASSWORD")
    return Broker.at(
        url,
        username=os.environ.get(f"{prefix}_BROKER_USERNAME"),
        password=SecretStr(password) if password is not None else None,
        ca=ca if url.startswith("mqtts") else None,
    )


def main() -> int:
    """`python -m robots.adapters.vda5050`."""
    parser = argparse.ArgumentParser(prog="macta-robot vda5050", description=__doc__)
    add_arguments(parser)
    return run(parser.parse_args())
