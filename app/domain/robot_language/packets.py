"""A command's packet: which of the robot's packets is meant, with its arguments, or what to ask."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.words import joined
from app.domain.robot_language.references import Kind, candidates, resolve, which_one
from app.domain.robot_language.sentence import Amount, Command, Dimension, Phrase
from app.domain.robot_language.surroundings import Surroundings
from robots.repertoire import PacketSpec
from robots.repertoire.parameters import LIMITS
from robots.repertoire.wording import HOME, TIMEOUT, Wording
from robots.wire import BehaviourPacket

MIN_TIMEOUT_S = 30.0
TIMEOUT_FACTOR = 4.0
"""As of a mission's scripts (`mission_organiser.organise`)."""
WAIT_S = 60.0
USUAL_S = 15.0
"""How long a packet is taken to last beyond its way and its own times (our choice)."""
WAY_FACTOR = 1.5
"""A way is taken to be so much longer than the straight line (our choice)."""
UNFIT = "unfit-request"


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """The packet that is meant, and what the robot holds and "it" stands for after it."""

    packet: BehaviourPacket
    holding: str | None
    it: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Refused:
    """Why a packet is not meant, or what it lacks; of several the lowest rank is told."""

    rank: int
    clarification: Clarification


def words_of(spec: PacketSpec) -> tuple[Wording, ...]:
    """The packet's wordings; one without any is called by its tag, with its first argument as the object."""
    if spec.words:
        return spec.words
    first = next(iter((*spec.arguments, *(("object",) if spec.target else ()))), "")
    return (Wording(verbs=(spec.tag.lower().replace("_", " "),), object=first),)


def verbs_of(around: Surroundings) -> frozenset[str]:
    """The verbs that the robot understands."""
    return frozenset(verb for spec in around.packets for one in words_of(spec) for verb in one.verbs)


def choose(command: Command, around: Surroundings, *, number: int, it: str | None) -> Choice | Clarification:
    """The first of the robot's packets that the command fits, or what to ask.

    :param number: of the command in its sentence, for the packet's id. :param it: what "it" stands for.
    """
    refused: list[_Refused] = []
    for spec in around.packets:
        for wording in words_of(spec):
            if command.verb not in wording.verbs and command.verb != spec.tag.lower().replace("_", " "):
                continue
            made = _Match(command, spec, wording, around, it).choice(number)
            if isinstance(made, Choice):
                return made
            refused.append(made)
    return min(refused, key=lambda one: one.rank).clarification


@dataclass(frozen=True, slots=True)
class _Match:
    """A command held against one wording of one packet."""

    command: Command
    spec: PacketSpec
    wording: Wording
    around: Surroundings
    it: str | None

    def choice(self, number: int) -> Choice | _Refused:
        try:
            arguments = self._arguments()
        except _Lacking as lacking:
            return lacking.refused
        timeout_s = float(arguments.pop(TIMEOUT, 0.0))
        expected_s = timeout_s or self._expected_s(arguments)
        held = self._held_after(arguments)
        named = [value for name, value in arguments.items() if self._kind(name) in (Kind.THING, Kind.SAMPLE)]
        return Choice(
            packet=BehaviourPacket(
                id=f"{self.spec.tag.lower()}_{number}",
                tag=self.spec.tag,
                arguments=arguments,
                expected_start_s=0.0,
                expected_duration_s=expected_s,
                timeout_s=timeout_s or max(MIN_TIMEOUT_S, TIMEOUT_FACTOR * expected_s),
                wait_timeout_s=WAIT_S,
                description=f"{self.spec.tag}({', '.join(f'{k} {v}' for k, v in arguments.items())})",
            ),
            holding=held,
            it=named[0] if named else self.it,
        )

    def _arguments(self) -> dict[str, str]:
        """:raises _Lacking: with what is wrong or missing."""
        self._check_parts()
        arguments = {name: self._set(value) for name, value in self.wording.sets.items()}
        for amount in self.command.amounts:
            name, sign = self._amount(amount)
            arguments[name] = f"{sign * amount.value:g}"
        at = self._restriction()
        for name, phrase in self._phrases():
            arguments[name] = self._named(name, phrase, at)
        for name, phrase in self.command.given.items():
            arguments[name] = self._given(name, phrase)
        self._check_before(arguments)
        self._check_numbers(arguments)
        for name in (*self.spec.arguments, *(("object",) if self.spec.target else ())):
            if name not in arguments and not (self.spec.target and {"x", "y"} <= arguments.keys()):
                raise self._missing(name)
        return arguments

    def _check_parts(self) -> None:
        """Refuse parts of the command that the wording has no argument for."""
        fills = [
            *self.spec.arguments,
            *self.spec.parameters,
            *LIMITS,
            *(("object", "x", "y") if self.spec.target else ()),
        ]
        for name, phrase in self.command.given.items():
            if name not in (*fills, *self.spec.optional, TIMEOUT):
                raise self._refused(
                    5, f"{self.spec.tag} has no {name}", thing=name, choices=tuple(fills), span=phrase.span
                )
        part = self.command.object
        if part is not None and not self.wording.object:
            raise self._refused(5, f"{self.command.verb!r} takes no object", thing=part.said, span=part.span)
        part = self.command.target
        if part is not None and not (self.wording.target or self.wording.object):
            raise self._refused(5, f"{self.command.verb!r} takes no place", thing=part.said, span=part.span)

    def _phrases(self) -> Iterator[tuple[str, Phrase]]:
        """The phrases of the command by the arguments that they fill."""
        if self.command.object is not None:
            yield self.wording.object, self.command.object
        if self.command.target is not None and self.wording.target:
            yield self.wording.target, self.command.target

    def _restriction(self) -> str | None:
        """The place at which the object is said to be: "face the sample at bay_3"."""
        if self.command.target is None or self.wording.target or self.command.object is None:
            return None
        return self._resolved(self.command.target, Kind.PLACE, None)

    def _named(self, name: str, phrase: Phrase, at: str | None) -> str:
        found = self._resolved(phrase, self._kind(name), at)
        if (zone := self.around.kept_out.get(found)) is not None:
            raise self._refused(
                4, f"{found} lies in {zone}, which no robot enters", thing=found, span=phrase.span
            )
        return found

    def _given(self, name: str, phrase: Phrase) -> str:
        if name in ("object", *self.spec.arguments):
            return self._named(name, phrase, None)
        return phrase.said

    def _resolved(self, phrase: Phrase, kind: Kind, at: str | None) -> str:
        it = self.around.holding or self.it
        found = resolve(phrase, kind, self.around, it=it, at=at)
        if isinstance(found, str):
            return found
        is_which = len(found.choices) > 1 and found.code == "which-one"
        raise _Lacking(_Refused(rank=1 if is_which else 3, clarification=found))

    def _kind(self, name: str) -> Kind:
        if name in self.spec.places:
            return Kind.PLACE
        if name in self.spec.robots:
            return Kind.ROBOT
        return Kind.THING if self.spec.basic else Kind.SAMPLE

    def _set(self, value: str) -> str:
        if value != HOME:
            return value
        if self.around.home is None:
            raise self._refused(4, f"{self.around.robot} has no home", thing=self.command.verb)
        return self.around.home

    def _amount(self, amount: Amount) -> tuple[str, float]:
        """The parameter that an amount sets, and its sign."""
        names = {one.removeprefix("-"): -1.0 if one.startswith("-") else 1.0 for one in self.wording.amounts}
        for name, sign in names.items():
            if name.endswith(amount.dimension):
                return name, sign
        units = tuple(one.words for one in Dimension if any(name.endswith(one) for name in names))
        takes = f"takes a number of {joined(units)}" if units else "takes no number"
        detail = f"{self.command.verb!r} {takes}"
        raise self._refused(5, detail, span=amount.span)

    def _check_before(self, arguments: dict[str, str]) -> None:
        """Derive arguments from the packet's pre-conditions, and refuse what contradicts what the robot knows."""
        me = self.around.robot
        held = self.around.holding
        for condition in self.spec.before:
            sense = condition.get("sense")
            if sense == "empty" and held is not None:
                raise self._refused(4, f"{me} holds {held}; {self.spec.tag} needs empty jaws", thing=held)
            if sense == "holding":
                name = _argument(condition.get("object"))
                if held is None or arguments.setdefault(name, held) != held:
                    lacking = arguments.get(name, "nothing")
                    raise self._refused(4, f"{me} does not hold {lacking}; say take first", thing=lacking)
            if sense == "lies_at":
                self._check_place(
                    arguments, _argument(condition.get("object")), _argument(condition.get("place"))
                )

    def _check_place(self, arguments: dict[str, str], thing_name: str, place_name: str) -> None:
        thing = arguments.get(thing_name, "")
        believed = self.around.lies_at.get(thing)
        if not thing or believed is None:
            return
        if arguments.setdefault(place_name, believed) != believed:
            detail = f"{thing} is believed to be in {believed}, not in {arguments[place_name]}"
            raise self._refused(4, detail, thing=thing)
        if believed not in self.around.places:
            raise self._refused(
                4, f"{thing} is in {believed}, which is no place of {self.around.robot}", thing=thing
            )

    def _check_numbers(self, arguments: Mapping[str, str]) -> None:
        known = {**LIMITS, **self.spec.parameters}
        for name, value in arguments.items():
            if name in known:
                try:
                    known[name].read(value)
                except ValueError as error:
                    raise self._refused(3, f"{self.spec.tag}: {name} = {error}", thing=value) from None

    def _missing(self, name: str) -> "_Lacking":
        kind = self._kind(name)
        choices = candidates(kind, self.around)
        seen = tuple(one for one in choices if one in self.around.seen)
        is_object = name == self.wording.object
        link = "" if is_object else "to"
        if self.command.is_acl:
            link = f"{name}:"
        asked = which_one(Phrase(words=(), span=(self.command.end, self.command.end)), seen or choices)
        what = "which one" if kind is not Kind.PLACE else "which place"
        asked = replace(asked, detail=f"{self.command.verb}: {what}? {joined(asked.choices)}", link=link)
        return _Lacking(_Refused(rank=2, clarification=asked))

    def _refused(
        self,
        rank: int,
        detail: str,
        *,
        thing: str = "",
        choices: tuple[str, ...] = (),
        span: tuple[int, int] | None = None,
    ) -> "_Lacking":
        asked = Clarification(
            code=UNFIT, detail=detail, thing=thing, choices=choices, span=span or self.command.span
        )
        return _Lacking(_Refused(rank=rank, clarification=asked))

    def _held_after(self, arguments: Mapping[str, str]) -> str | None:
        """What the robot holds once the packet is done, by its post-conditions."""
        for condition in self.spec.after:
            if condition.get("sense") == "holding":
                return arguments.get(_argument(condition.get("object")))
            if condition.get("sense") == "empty":
                return None
        return self.around.holding

    def _expected_s(self, arguments: Mapping[str, str]) -> float:
        """How long the packet should take: its way at full speed, its own times, and `USUAL_S`."""
        goal = _argument(self.spec.goal)
        goal = "object" if goal == "target" else goal
        way_m = self.around.range_m(arguments[goal]) if goal in arguments else 0.0
        values = {name: one.default for name, one in self.spec.parameters.items()} | dict(arguments)
        way_m = abs(float(values.get("distance_m", 0.0))) if way_m == float("inf") else way_m
        own_s = float(values.get("for_s", 0.0))
        turn_rad = abs(float(values.get("angle_rad", 0.0)))
        return (
            USUAL_S + WAY_FACTOR * way_m / self.around.speed_m_s + own_s + turn_rad / self.around.turn_rad_s
        )


class _Lacking(Exception):
    """Raised within this module when a wording does not fit, or lacks something."""

    def __init__(self, refused: _Refused) -> None:
        super().__init__(refused.clarification.detail)
        self.refused = refused


def _argument(template: object) -> str:
    """The argument that a template such as `$object` names."""
    return str(template).removeprefix("$") if template is not None else ""
