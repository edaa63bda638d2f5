"""Where a world is kept, and what is to be made of it; an order for its process."""

from dataclasses import dataclass
from pathlib import Path

from robots.world import WorldFile


@dataclass(frozen=True, slots=True, kw_only=True)
class Keep:
    """Where a world is kept.

    :param run: the run to go on with, None if the record knows none.
    :param any_run: go on with whatever run is there: somebody else keeps the record.
    :param afresh: begin afresh whatever is there.
    :param resume_only: rather do not begin at all than afresh.
    """

    folder: Path
    run: str | None = None
    any_run: bool = False
    afresh: bool = False
    resume_only: bool = False

    def file_of(self, world: WorldFile) -> Path:
        return self.folder / f"{world.name}.json"
