"""What a robot's deliberative level restores after a power failure."""

from pydantic import Field

from robots.data import Checked


class MindMemory(Checked):
    """What the deliberative level restores after a power failure: rule files by name, with their version, the role that
    the robot plays, and what agents have adopted as beliefs, by the agent's name, as written in a rule file.
    Commitments are not kept.
    """

    version: int = 0
    files: dict[str, str] = Field(default_factory=dict)
    role: str = ""
    beliefs: dict[str, tuple[str, ...]] = Field(default_factory=dict)
