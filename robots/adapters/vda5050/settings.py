"""The settings of the adapter: one small YAML file, all of it optional (docs/vda5050.md)."""

from cmath import rect
from collections.abc import Mapping, Sequence
from math import dist, radians
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from pydantic import Field, ValidationError, model_validator
from typing_extensions import Self

from robots.adapters.vda5050.frame import Frame
from robots.adapters.vda5050.messages import BlockingType
from robots.adapters.vda5050.topics import INTERFACE, VehicleId
from robots.data import Checked, faults_in, read_yaml
from robots.errors import RobotError

Start = tuple[float, float, float]
"""x and y in metres, heading in degrees."""
APPROACH_M = 0.8
"""How far before a world file's location a robot is that is near it; as for robots of our own."""
NAME = r"^[a-z][a-z0-9_]*$"


class PlacePose(NamedTuple):
    """A pose in the world, radians; without a heading any will do."""

    x: float
    y: float
    heading_rad: float | None


def _place_pose(start: Start) -> PlacePose:
    return PlacePose(start[0], start[1], radians(start[2]))


class SettingsError(RobotError):
    """Raised when the settings cannot be used; says what and where."""


class ActionSettings(Checked):
    """An action of the vehicle. In parameters, `$name` stands for the packet's argument; without it, it is left out."""

    type: str = Field(min_length=1)
    blocking: BlockingType = BlockingType.HARD
    parameters: dict[str, Any] = Field(default_factory=dict)


class PacketSettings(Checked):
    """How a packet is carried out: drive, then act, then leave.

    `drive`: the argument that names the place; None: it stays where it is. `dock`: at the place itself, not before it.
    `leave`: it then drives back before the place. `grips` and `releases`: the argument that names what it then holds,
    and no longer holds. `needs`: actions that a vehicle must support to have the packet, beside those of `actions`.
    `announced`: it is in the repertoire of every vehicle that can do it, not only where `repertoire` lists it.
    """

    drive: str | None = None
    dock: bool = False
    actions: tuple[ActionSettings, ...] = ()
    leave: bool = False
    grips: str | None = None
    releases: str | None = None
    needs: tuple[str, ...] = ()
    announced: bool = True


class PlaceSettings(Checked):
    """A place in the world's frame: the pose before it; without a heading any will do.

    `others`: further poses before it, on its other sides; the nearest is taken. `dock`: the pose at it, for packets
    that dock there (default: the one before it). `node`: what the vehicle calls the place (default: its name).
    """

    x: float
    y: float
    heading_deg: float | None = None
    others: tuple[Start, ...] = ()
    dock: Start | None = None
    node: str | None = None

    def pose(self, *, dock: bool = False, near: tuple[float, float] | None = None) -> "PlacePose":
        """The pose before the place that is nearest to a point (default: the first one), or docked at it."""
        if dock and self.dock is not None:
            return _place_pose(self.dock)
        heading_rad = None if self.heading_deg is None else radians(self.heading_deg)
        poses = [PlacePose(self.x, self.y, heading_rad), *map(_place_pose, self.others)]
        return poses[0] if near is None else min(poses, key=lambda one: dist(near, one[:2]))


class VehicleSettings(Checked):
    """One vehicle. `robot`: its name in the world; `frame`: if it is not that of all vehicles.

    The rest stands for what its factsheet does not say.
    """

    robot: str | None = Field(default=None, pattern=NAME, max_length=64)
    frame: Frame | None = None
    repertoire: tuple[str, ...] | None = None
    speed_m_s: float | None = Field(default=None, gt=0, le=2)
    turn_rad_s: float | None = Field(default=None, gt=0, le=6)
    compartment: str | None = None
    aisle: str | None = None
    home: str | None = None


def _pick() -> ActionSettings:
    return ActionSettings(type="pick", parameters={"stationName": "$ref1", "loadId": "$object"})


def _drop() -> ActionSettings:
    return ActionSettings(type="drop", parameters={"stationName": "$ref2", "loadId": "$object"})


def default_packets() -> dict[str, PacketSettings]:
    """The packets that are known without a file."""
    return {
        "NAVIGATE": PacketSettings(drive="ref2"),
        "TRANSPORT": PacketSettings(drive="ref2", needs=("pick", "drop")),
        "DOCK": PacketSettings(drive="ref1", dock=True, actions=(_pick(),), grips="object"),
        "RELEASE": PacketSettings(
            drive="ref2", dock=True, actions=(_drop(),), releases="object", announced=False
        ),
        "RELEASE2": PacketSettings(
            drive="ref2", dock=True, actions=(_drop(),), leave=True, releases="object"
        ),
        "CHARGE": PacketSettings(
            drive="charger", actions=(ActionSettings(type="startCharging"),), announced=False
        ),
        "STOP_CHARGING": PacketSettings(actions=(ActionSettings(type="stopCharging"),), announced=False),
        "WAIT": PacketSettings(
            drive="place",
            actions=(ActionSettings(type="waitForTrigger", parameters={"triggerType": ["LOCAL"]}),),
            announced=False,
        ),
    }


class Settings(Checked):
    """All settings.

    `interface`, `versions`: the topics that are listened to. `places`: where the places of packets are; those of
    `world_file`, a world file's `locations`, are added. `packets` replace or extend the known ones; `action_parameters`
    are added to every action of a type. `horizon`: whether vehicles are told what is planned beyond what is released.
    `vehicles` by `manufacturer/serial number`. `only_listed`: vehicles that are not listed are left alone.
    `states`: the exact version that robots as vehicles state, for master controls that take no other.
    """

    interface: str = Field(default=INTERFACE, pattern=r"^[^/+#$]+$")
    versions: tuple[int, ...] = (2, 3)
    frame: Frame = Frame()
    places: dict[str, PlaceSettings] = Field(default_factory=dict)
    world_file: Path | None = None
    packets: dict[str, PacketSettings] = Field(default_factory=dict)
    action_parameters: dict[str, dict[str, Any]] = Field(default_factory=dict)
    horizon: bool = True
    deviation_m: float = Field(default=0.2, gt=0)
    deviation_rad: float = Field(default=0.2, gt=0, le=3.14159)
    speed_m_s: float = Field(default=0.5, gt=0, le=2, description="of vehicles that do not say theirs")
    turn_rad_s: float = Field(default=1.0, gt=0, le=6)
    vehicles: dict[str, VehicleSettings] = Field(default_factory=dict)
    only_listed: bool = False
    states: str | None = Field(default=None, pattern=r"^[23]\.\d+\.\d+$")

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if not self.versions or set(self.versions) - {2, 3}:
            raise ValueError(f"versions: {list(self.versions)}; choices: 2, 3")
        robots = [one.robot for one in self.vehicles.values() if one.robot is not None]
        if twice := {name for name in robots if robots.count(name) > 1}:
            raise ValueError(f"vehicles: two of them are called {', '.join(sorted(twice))}")
        for key in self.vehicles:
            if key.count("/") != 1 or not all(key.split("/")):
                raise ValueError(f"vehicles: {key!r} is not of the form manufacturer/serial number")
        return self

    @property
    def all_packets(self) -> Mapping[str, PacketSettings]:
        """By tag."""
        return default_packets() | self.packets

    def of(self, vehicle: VehicleId) -> VehicleSettings:
        """A vehicle's own settings; the defaults if it has none."""
        return self.vehicles.get(str(vehicle), VehicleSettings())

    def frame_of(self, vehicle: VehicleId) -> Frame:
        return self.of(vehicle).frame or self.frame


def load_settings(path: Path | None, *, world_file: Path | None = None) -> Settings:
    """Read and check a file of settings, and the places of a world file.

    :param path: None: the defaults.
    :param world_file: takes the place of the one that the settings name.
    :raises SettingsError: naming the file, the line and the slot.
    """
    settings = Settings() if path is None else _read(path)
    if settings.world_file is not None and path is not None and world_file is None:
        world_file = path.parent / settings.world_file
    if world_file is None:
        return settings
    found = places_of_world(world_file)
    return settings.model_copy(update={"places": found | settings.places, "world_file": world_file})


def _read(path: Path) -> Settings:
    text = _text(path)
    try:
        data = read_yaml(text)
    except (yaml.YAMLError, ValueError) as error:
        raise SettingsError(f"{path} cannot be read: {error}") from error
    if data is None:
        data = {}
    if not isinstance(data, dict):
        raise SettingsError(f"{path} does not contain a mapping of settings")
    try:
        return Settings.model_validate(data)
    except ValidationError as error:
        lines = "\n".join(f"  {fault}" for fault in faults_in(text, error))
        raise SettingsError(f"{path} has settings that do not fit:\n{lines}") from error


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"{path} cannot be read: {error}") from error


class _Location(Checked):
    """What of a world file's location matters here."""

    model_config = Checked.model_config | {"extra": "ignore"}
    name: str
    at: tuple[float, float]
    approach_deg: tuple[float, ...] = Field(default=(0.0,), min_length=1)


def places_of_world(path: Path) -> dict[str, PlaceSettings]:
    """The places of a world file: each on the axis of its first approach, facing it.

    NOTE: only `locations` are read: an adapter is no part of the simulation and knows nothing else of the file.
    :raises SettingsError: if there are none.
    """
    try:
        data = read_yaml(_text(path))
        listed = data.get("locations") if isinstance(data, dict) else None
        locations = [_Location.model_validate(one) for one in listed or ()]
    except (yaml.YAMLError, ValueError) as error:
        raise SettingsError(f"{path} cannot be read as a world file: {error}") from error
    if not locations:
        raise SettingsError(f"{path} has no locations; it is no world file")
    return {one.name: place_at(one.at, one.approach_deg) for one in locations}


def place_at(at: tuple[float, float], approaches_deg: Sequence[float]) -> PlaceSettings:
    """The place of a beacon that is approached from these directions: `APPROACH_M` before it, facing it."""
    first, *others = [_before(at, one) for one in approaches_deg]
    return PlaceSettings(x=first[0], y=first[1], heading_deg=first[2], others=tuple(others))


def _before(at: tuple[float, float], approach_deg: float) -> Start:
    away = rect(APPROACH_M, radians(approach_deg))
    heading_deg = (approach_deg + 180.0) % 360.0
    facing_deg = heading_deg - 360.0 if heading_deg > 180.0 else heading_deg
    return round(at[0] + away.real, 6), round(at[1] + away.imag, 6), facing_deg
