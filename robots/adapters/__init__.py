"""Robots that are not ours, kept to the contract with the service packet by packet."""

from robots.adapters.contract_robot import ContractRobot
from robots.adapters.driver import DriverMemory, PacketDriver, Progress, ProgressState, SensingDriver
from robots.adapters.packet_forms import PacketForm

__all__ = [
    "ContractRobot",
    "DriverMemory",
    "PacketDriver",
    "PacketForm",
    "Progress",
    "ProgressState",
    "SensingDriver",
]
