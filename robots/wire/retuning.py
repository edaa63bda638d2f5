"""The messages by which an operator tunes a robot's packets at run time."""

from typing import Literal

from pydantic import Field

from robots.wire.script import Wire

PacketTunings = dict[str, dict[str, dict[str, float]]]
"""By packet's tag, pattern ("dof/name") and parameter ("stimulus.reach_m") the number that it is to be."""


class Retune(Wire):
    """Service to robot: from the next packet on these parameters are what they are here (request).

    They come on top of what the robot was set out with, and replace all that were sent before. `version` counts up.
    """

    kind: Literal["retune"] = "retune"
    version: int = Field(ge=0)
    tuning: PacketTunings


class TuningReport(Wire):
    """Robot to service: the tuning of that version is in use (agree), or not, for a reason (refuse)."""

    kind: Literal["tuning_report"] = "tuning_report"
    version: int
    reason: str = ""
