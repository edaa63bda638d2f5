"""Reads occupancy grids of ROS's map_server: a YAML file that names a PGM image (wiki.ros.org/map_server)."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import yaml
from numpy.typing import NDArray
from pydantic import ConfigDict, Field, ValidationError, model_validator
from typing_extensions import Self

from robots.data import Checked, faults_in, read_yaml

MAX_YAML_BYTES = 64 * 1024
MAX_IMAGE_BYTES = 64 * 2**20
MAX_CELLS = 16_000_000
"""200 m by 200 m of 5 cm cells, what ROS's mapping programs make if they are asked for nothing else."""
SPACE = rb"(?:\s|#[^\n]*+\n)++"

Share = Annotated[float, Field(ge=0, le=1)]
Far = Annotated[float, Field(ge=-1e5, le=1e5)]


class RosMapError(ValueError):
    """Raised when a map cannot be read or imported; names the file, the key or byte, and what to do."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OccupancyGrid:
    """Square cells of floor.

    :ivar free: shape (rows, columns), true where the floor is known to be free; row 0 is the southernmost.
    :ivar origin: of the outer corner of cell (0, 0): x and y in metres, and the heading of its rows in radians.
    """

    free: NDArray[np.bool_]
    resolution_m: float
    origin: tuple[float, float, float]


class _Keys(Checked):
    """The keys of map.yaml, as map_server defines them; others are ignored, as there."""

    model_config = ConfigDict(extra="ignore")

    image: Annotated[str, Field(min_length=1)]
    resolution: Annotated[float, Field(ge=0.005, le=1)]
    origin: tuple[Far, Far, Far]
    negate: bool
    occupied_thresh: Share
    free_thresh: Share
    mode: Literal["trinary"] = "trinary"

    @model_validator(mode="after")
    def _thresholds_are_in_order(self) -> Self:
        if self.free_thresh > self.occupied_thresh:
            raise ValueError(
                f"free_thresh must be at most occupied_thresh, which is {self.occupied_thresh:g}"
            )
        return self


def read_ros_map(file: Path) -> OccupancyGrid:
    """Read map.yaml and the image that it names.

    A cell is free if its probability of being occupied is less than `free_thresh`. Unknown cells are not free.

    :raises RosMapError: if a file is missing, too large or not valid, or the map's mode is not trinary.
    """
    keys = _read_keys(file)
    image = file.parent / keys.image
    values, maxval = _read_pgm(image, _read(image, MAX_IMAGE_BYTES))
    shades = np.arange(maxval + 1) / maxval
    is_free = (shades if keys.negate else 1 - shades) < keys.free_thresh
    return OccupancyGrid(free=is_free[values[::-1]], resolution_m=keys.resolution, origin=keys.origin)


def _read_keys(file: Path) -> _Keys:
    try:
        text = _read(file, MAX_YAML_BYTES).decode()
        data = read_yaml(text)
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise RosMapError(f"{file} is not YAML: {error}") from error
    except RosMapError:
        raise
    except ValueError as error:
        raise RosMapError(f"{file} cannot be read: {error}") from error
    if not isinstance(data, dict):
        raise RosMapError(f"{file}: a mapping with the keys {', '.join(_Keys.model_fields)} is needed")
    if data.get("mode") in ("scale", "raw"):
        raise RosMapError(
            f"{file}: mode: {data['mode']} has no free or occupied cells; save the map with mode: trinary"
        )
    try:
        return _Keys.model_validate(data)
    except ValidationError as error:
        raise RosMapError("\n".join([f"{file}:", *faults_in(text, error)])) from error


def _read(file: Path, max_bytes: int) -> bytes:
    try:
        if not file.is_file():
            raise RosMapError(f"{file}: there is no such file")
        with file.open("rb") as opened:
            data = opened.read(max_bytes + 1)
    except OSError as error:
        raise RosMapError(f"{file} cannot be read: {error.strerror}") from error
    if len(data) > max_bytes:
        raise RosMapError(f"{file} has more than {max_bytes:,} bytes; crop the map or make its cells larger")
    return data


def _read_pgm(file: Path, data: bytes) -> tuple[NDArray[np.uint16], int]:
    """The image's values, shape (rows, columns) from the top, and the value of white (netpbm's pgm(5))."""
    if data[:2] not in (b"P2", b"P5"):
        raise RosMapError(
            f"{file}: byte 0: no PGM image, which begins with P2 or P5; convert it to PGM, and name that as image"
        )
    at = 2
    header = []
    for name, most in (("width", MAX_CELLS), ("height", MAX_CELLS), ("maxval", 65535)):
        found = re.compile(SPACE + rb"(\d{1,9}+)(?=\s)").match(data, at)
        if found is None or not 1 <= int(found[1]) <= most:
            raise RosMapError(f"{file}: byte {at}: the {name} must follow, a number from 1 to {most:,}")
        header.append(int(found[1]))
        at = found.end()
    width, height, maxval = header
    cells = width * height
    if cells > MAX_CELLS:
        raise RosMapError(
            f"{file}: {width} x {height} cells are more than {MAX_CELLS:,}; crop the map or make its cells larger"
        )
    if data[:2] == b"P2":
        if found := re.compile(rb"[^\d\s]").search(data, at):
            raise RosMapError(f"{file}: byte {found.start()}: {found[0]!r} is no part of a number")
        values = np.fromstring(data[at:].decode(), dtype=np.float32, sep=" ")
    else:
        values = np.frombuffer(data[at + 1 :][: cells * 2], dtype=np.uint8)
        if maxval > 255:
            values = values[: len(values) // 2 * 2].view(">u2")
    if len(values) < cells:
        raise RosMapError(f"{file}: byte {len(data)}: the image ends after {len(values)} of {cells} cells")
    values = values[:cells]
    worst = int(np.argmax(values))
    if values[worst] > maxval:
        raise RosMapError(
            f"{file}: row {worst // width + 1}, column {worst % width + 1}: the value is more than maxval, {maxval}"
        )
    return values.astype(np.uint16).reshape(height, width), maxval
