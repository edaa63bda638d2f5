"""Keep the contract with Macta for a robot that is driven by ROS 2 actions (docs/ros2.md)."""

import argparse
import os
import sys
import time
from pathlib import Path

from pydantic import SecretStr

from robots.adapters.contract_robot import ContractRobot
from robots.adapters.ros2.driver import Ros2Driver
from robots.adapters.ros2.parameters import ParameterError, PoseFrame, Ros2Parameters, read_parameters
from robots.adapters.ros2.ros import Ros, RosError, load_ros, spin
from robots.contract.memory_file import MemoryFile, counter_file
from robots.errors import RobotError
from robots.link.mqtt import Broker, BrokerError, RobotLink
from robots.wire import Factsheet

TICK_S = 0.1


class MonotonicClock:
    """This machine's clock; implements `robots.clock.Clock`."""

    def now_s(self) -> float:
        return time.monotonic()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("parameters", type=Path, help="the parameter file, as examples/ros2/robot.yaml")
    parser.add_argument("--broker", required=True, help="mqtt://HOST[:PORT] or mqtts://HOST[:PORT]")
    parser.add_argument("--ca", type=Path, help="the authority's certificate, for mqtts")
    parser.add_argument("--certificate", type=Path, help="the robot's own certificate")
    parser.add_argument("--key", type=Path, help="its key")


def run(arguments: argparse.Namespace) -> int:
    """Serve the robot until it is interrupted; answers the exit status."""
    try:
        parameters = read_parameters(arguments.parameters)
        broker = Broker.at(
            arguments.broker,
            username=os.environ.get("MACTA_BROKER_USERNAME"),
            password=_secret("MACTA_BROKER_PASSWORD"),
            ca=arguments.ca,
            certificate=arguments.certificate,
            key=arguments.key,
        )
        ros = load_ros(f"macta_{parameters.robot}", transforms=isinstance(parameters.pose, PoseFrame))
        _serve(ros, parameters, broker)
    except (ParameterError, BrokerError, RosError, RobotError, OSError, ValueError) as error:
        print(f"macta-robot ros2: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 0
    return 0


def _serve(ros: Ros, parameters: Ros2Parameters, broker: Broker) -> None:
    key = _secret("MACTA_ROBOT_KEY")
    link = RobotLink(
        parameters.world,
        [parameters.robot],
        broker,
        keys={parameters.robot: key.get_secret_value()} if key else {},
        counters={parameters.robot: counter_file(parameters.memory)},
    )
    robot = ContractRobot(
        parameters.robot,
        driver=Ros2Driver(ros, parameters, MonotonicClock()),
        packets=parameters.forms,
        link=link,
        clock=link.clock,
        store=MemoryFile(parameters.memory),
        factsheet=Factsheet(
            repertoire=tuple(sorted(parameters.packets)),
            speed_m_s=parameters.speed_m_s,
            turn_rad_s=parameters.turn_rad_s,
        ),
    )
    link.start()
    try:
        while True:
            next_s = time.monotonic() + TICK_S
            if link.run is not None:
                robot.enter_run(link.run)
                robot.tick()
            while (left_s := next_s - time.monotonic()) > 0:
                spin(ros, left_s)
    finally:
        link.close()


def _secret(name: str) -> SecretStr | None:
    value = os.environ.get(name)
    return SecretStr(value) if value is not None else None
