"""Loads packets' contents and binds packets of the wire to them."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from importlib import resources
from pathlib import Path

import yaml
from pydantic import ValidationError

from robots.conditions.facts import CONDITIONS_OF, condition_for
from robots.conditions.verdict import Condition
from robots.data import faults_in, place_in, read_yaml
from robots.errors import RepertoireError
from robots.perception.percepts import waypoint
from robots.physical.body import ALL_SENSORS
from robots.physical.profile import RobotProfile
from robots.repertoire.check import template_faults
from robots.repertoire.parameters import LIMITS, Value
from robots.repertoire.schema import BoundPacket, PacketSpec
from robots.repertoire.self_level import FILE as SELF_LEVEL
from robots.repertoire.self_level import load_self_level
from robots.repertoire.sensed_facts import KEY, SensedFact, SensedFacts
from robots.repertoire.tuning import Tuning, tuned
from robots.wire import BehaviourPacket, SymbolicFact

TARGET = ("object", "x", "y")
OBJECT_STAND_OFF_M = 0.6
"""A robot stops this far from an object's middle; at a way-point it stops on the point."""


@dataclass(frozen=True, slots=True)
class Repertoire:
    """The packets of the on-robot software; a robot's profile says which of them it may use."""

    specs: Mapping[str, PacketSpec]
    sensed: tuple[SensedFact, ...] = ()
    """Of facts beside those of `robots.conditions.facts`."""

    @property
    def tags(self) -> tuple[str, ...]:
        """The tags that a robot's profile may name: of the packets that not every robot has."""
        return tuple(sorted({spec.tag for spec in self.specs.values() if not spec.basic}))

    @property
    def basic_tags(self) -> tuple[str, ...]:
        """The tags of the packets that every robot has."""
        return tuple(sorted({spec.tag for spec in self.specs.values() if spec.basic}))

    def tuned(self, tuning: Mapping[str, Tuning]) -> "Repertoire":
        """The repertoire with overridden parameters, by packet tag.

        :raises RepertoireError: naming packet, pattern and parameter.
        """
        for tag in tuning:
            self._known(tag)
        specs = {name: tuned(spec, tuning.get(name, {})) for name, spec in self.specs.items()}
        return Repertoire(specs, self.sensed)

    def condition_for(self, fact: SymbolicFact, profile: RobotProfile) -> Condition:
        """The sensor condition by which this robot perceives that a fact has become true.

        :raises RepertoireError: if none of its sensors can perceive it.
        """
        for one in self.sensed:
            if (condition := one.condition(fact, profile.name)) is not None:
                return condition
        return condition_for(fact, profile)

    def senses(
        self,
        further: Collection[str] = (),
        quantities: Collection[str] | None = None,
        own: Collection[str] = ALL_SENSORS,
    ) -> frozenset[str]:
        """The predicates whose facts a robot with these sensors perceives: each condition for them can be checked.

        :param further: cameras, and sensors of installed packages.
        :param quantities: what those measure; None: that is not known, and taken to suffice.
        """
        sensors = frozenset(own).union(further)
        usual = {
            predicate
            for predicate, conditions in CONDITIONS_OF.items()
            if all(condition.needs_of_all() <= sensors for condition in conditions)
        }
        stated = {one.predicate for one in self.sensed}
        lacking = {one.predicate for one in self.sensed if not one.is_perceived_with(sensors, quantities)}
        return frozenset((usual | stated) - lacking)

    def _known(self, tag: str) -> PacketSpec:
        spec = self.specs.get(tag)
        if spec is None:
            raise RepertoireError(f"unknown packet {tag}; known: {', '.join(sorted(self.specs))}")
        return spec

    def _content(self, packet: BehaviourPacket, profile: RobotProfile) -> PacketSpec:
        """The content for a packet's tag and object: long objects may have one of their own."""
        thing = packet.arguments.get("object")
        long = f"{packet.tag} (long)"
        if long in self.specs and (thing in profile.lengths_m or packet.tag not in self.specs):
            if thing is not None and thing not in profile.lengths_m:
                raise RepertoireError(
                    f"{packet.tag} needs a long object; {thing} is not one for {profile.name}"
                )
            return self.specs[long]
        return self._known(packet.tag)

    def bind(self, packet: BehaviourPacket, profile: RobotProfile) -> BoundPacket:
        """The content of a packet of the wire; conditions for `awaits` are added to its pre-conditions.

        :raises RepertoireError: naming the tag, argument or fact that does not fit.
        """
        spec = self._content(packet, profile)
        if not spec.basic and packet.tag not in profile.repertoire:
            raise RepertoireError(f"{packet.tag} is not in the repertoire of {profile.name}")
        _check_arguments(packet, spec, profile)
        values = {
            **packet.arguments,
            **_target(packet, spec),
            **_parameters(packet, spec),
            "me": profile.name,
        }
        bound = tuned(spec, packet.tuning).bind(values, packet.timeout_s)
        awaited = tuple(self.condition_for(fact, profile) for fact in packet.awaits)
        return replace(bound, before=(*bound.before, *(one for one in awaited if one not in bound.before)))


def _check_arguments(packet: BehaviourPacket, spec: PacketSpec, profile: RobotProfile) -> None:
    missing = [name for name in spec.arguments if name not in packet.arguments]
    if missing:
        raise RepertoireError(f"{packet.tag} lacks the argument {', '.join(missing)}")
    if spec.basic:
        _check_names(packet, spec)
    for name in spec.places:
        place = packet.arguments[name]
        if place not in profile.places:
            known = ", ".join(sorted(profile.beacons))
            raise RepertoireError(
                f"{packet.tag}: {name} = {place} is not a place that {profile.name} knows; known: {known}"
            )
    for name in spec.robots:
        robot = packet.arguments[name]
        if robot not in (*profile.others, profile.name):
            raise RepertoireError(f"{packet.tag}: {name} = {robot} is not a robot that {profile.name} knows")


def _check_names(packet: BehaviourPacket, spec: PacketSpec) -> None:
    """Refuse unknown parameters of basic packets; others have all those of their plan-net action (table 3)."""
    known = {*spec.arguments, *spec.optional, *spec.parameters, *LIMITS, *(TARGET if spec.target else ())}
    unknown = sorted(packet.arguments.keys() - known)
    if unknown:
        raise RepertoireError(
            f"{packet.tag} has no parameter {', '.join(unknown)}; known: {', '.join(sorted(known))}"
        )


def _parameters(packet: BehaviourPacket, spec: PacketSpec) -> dict[str, Value]:
    """The parameters and limits that the packet sets."""
    values: dict[str, Value] = {}
    for name, parameter in {**LIMITS, **spec.parameters}.items():
        if name in packet.arguments:
            try:
                values[name] = parameter.read(packet.arguments[name])
            except ValueError as error:
                raise RepertoireError(f"{packet.tag}: {name} = {error}") from None
    return values


def _target(packet: BehaviourPacket, spec: PacketSpec) -> dict[str, Value]:
    """The target of a packet: an object, or a way-point of the world's frame."""
    given = packet.arguments
    if not spec.target:
        return {}
    if ("object" in given) == ("x" in given and "y" in given):
        raise RepertoireError(f"{packet.tag} needs either object, or x and y")
    if "object" in given:
        return {"target": given["object"], "stand_off_m": OBJECT_STAND_OFF_M}
    try:
        return {"target": waypoint(float(given["x"]), float(given["y"])), "stand_off_m": 0.0}
    except ValueError:
        raise RepertoireError(f"{packet.tag}: x = {given['x']}, y = {given['y']} is not a point") from None


def load_repertoire(texts: Iterable[tuple[str, str]] | None = None) -> Repertoire:
    """Read and check packets' contents.

    :param texts: pairs of a name and its YAML text; None reads the ones shipped here.
    :raises RepertoireError: naming the text, the line and slot, and what is wrong with it.
    """
    return read_repertoire(store_packets()) if texts is None else _checked(texts)


def store_packets() -> tuple[Path, ...]:
    """The files of the sample store's packets."""
    return _shipped("store")


def read_repertoire(files: Iterable[Path]) -> Repertoire:
    """The packets that every robot has, and those of the files; all that drive have the self level's patterns, too.

    :raises RepertoireError: naming the file, the line and slot, and what is wrong with it.
    """
    return _with_self_level(tuple((str(file), _text(file)) for file in (*_shipped(), *files)))


@lru_cache(maxsize=4)
def _with_self_level(texts: tuple[tuple[str, str], ...]) -> Repertoire:
    # NOTE: checking takes 60 ms, too long for every robot of a large world.
    packets = _checked(texts)
    own = load_self_level()
    return Repertoire({tag: own.added_to(spec) for tag, spec in packets.specs.items()}, packets.sensed)


def _checked(texts: Iterable[tuple[str, str]]) -> Repertoire:
    read: dict[str, tuple[str, PacketSpec]] = {}
    sensed: list[SensedFact] = []
    for origin, text in texts:
        spec = _content(origin, text)
        if isinstance(spec, SensedFacts):
            sensed += spec.sensed_facts
            continue
        if spec.name in read:
            raise RepertoireError(
                f"{origin} defines {spec.name} a second time; it is defined in {read[spec.name][0]}"
            )
        read[spec.name] = origin, spec
    own = {name: spec.patterns for name, (_, spec) in read.items()}
    specs = {}
    for name, (origin, spec) in read.items():
        try:
            specs[name] = spec.with_patterns_of(own)
            specs[name].bind({})
        except ValueError as error:
            raise RepertoireError(f"{origin} is no packet: {error}") from error
    return Repertoire(specs, tuple(sensed))


def read_packet(file: Path) -> PacketSpec | SensedFacts:
    """One packet's content, or the sensed facts of a file that holds no packet; not checked against others.

    :raises RepertoireError: naming the file, the line and slot, and what is wrong with it.
    """
    return _content(str(file), _text(file))


@lru_cache(maxsize=64)
def _content(origin: str, text: str) -> PacketSpec | SensedFacts:
    spec: PacketSpec | SensedFacts
    try:
        data = read_yaml(text)
        if isinstance(data, dict) and KEY in data:
            spec = SensedFacts.model_validate(data)
            found = (
                ((KEY, index, *slot), message)
                for index, one in enumerate(spec.sensed_facts)
                for slot, message in one.faults()
            )
        else:
            spec = PacketSpec.model_validate(data)
            found = ((slot, message) for slot, message in template_faults(spec))
        faults = [place_in(text, slot, message) for slot, message in found]
    except ValidationError as error:
        faults = faults_in(text, error)
    except (yaml.YAMLError, ValueError) as error:
        raise RepertoireError(f"{origin} is no packet: {error}") from error
    if faults:
        raise RepertoireError("\n".join([f"{origin} is no packet:", *(f"  {fault}" for fault in faults)]))
    return spec


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RepertoireError(f"{file} cannot be read: {error}") from error


@cache
def _shipped(*folders: str) -> tuple[Path, ...]:
    with resources.as_file(resources.files("robots.repertoire").joinpath(*folders)) as folder:
        return tuple(path for path in sorted(folder.glob("*.yaml")) if path.name != SELF_LEVEL)
