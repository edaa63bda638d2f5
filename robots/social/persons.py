"""What a robot does at a person's word (SRA: the human as an agent): requests, the order to stop, and questions.

request perform(SCRIPT, packet(FACE_OBJECT, 20, object(sample_1)), ...)    agree; then inform done(SCRIPT), or failure
request halt(SCRIPT)    inform halted once that script has ended, or refuse; without a name, whichever the robot is at
query-ref seen, position, battery, activity, held, beliefs, place(sample_1)    inform seen(sample_1, door_1)
query-if sees(sample_1), holds(sample_1)    inform sees(sample_1), or not(sees(sample_1))

A person speaks through the service, which names the speaker. The packets become a script of the robot's own: a robot
that carries out a script of a mission, or that somebody drives, refuses. A mission's script that arrives ends it.
"""

from cmath import rect
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from robots.contract.known_scripts import ENDED
from robots.contract.memory import PersonsRequestMemory
from robots.executive.society import Situated
from robots.perception.percepts import LOCATING, NOTHING, Needs, Percepts
from robots.social.legs import call_of, leg_of
from robots.social.speech import Heard, Reply
from robots.social.terms import Argument, ContentError, Term
from robots.wire import (
    MAX_CONTENT,
    OWN,
    SAID,
    BehaviourPacket,
    BehaviourScript,
    Performative,
    ScriptState,
    SpeechAct,
)

PERFORM = "perform"
HALT = "halt"
LOOK_S = 5.0
"""How long the robot waits for the reading that a question needs (our choice)."""
NEAR_M = 1.5
"""A robot within this of a place's middle says that it is near (our choice)."""
MAX_HALTED = 64
"""Scripts of which the robot remembers that they were withdrawn, should they arrive late (our choice)."""
MAX_NAMED = 64
"""Names or beliefs in one answer."""

Answer = Callable[[Heard, Reply], None]


@dataclass(slots=True)
class _Look:
    """A question that waits for a reading."""

    asked: Heard
    until_s: float


class PersonsRequests:
    """A robot's part in what persons ask of it."""

    def __init__(self, name: str, answer: Answer, is_open: Callable[[Heard], bool]) -> None:
        """
        :param answer: says something later in the conversation of what was heard.
        :param is_open: whether that conversation has not ended.
        """
        self._name = name
        self._answer = answer
        self._is_open = is_open
        self._running: list[tuple[BehaviourScript, Heard]] = []
        self._looks: list[_Look] = []
        self._halted: deque[str] = deque(maxlen=MAX_HALTED)
        self.handlers: Mapping[tuple[Performative, str], Callable[[Heard, Situated], Reply | None]] = {
            (Performative.REQUEST, PERFORM): self._perform,
            (Performative.REQUEST, HALT): self._halt,
            (Performative.QUERY_REF, "position"): self._position,
            (Performative.QUERY_REF, "battery"): self._battery,
            (Performative.QUERY_REF, "activity"): self._activity,
            (Performative.QUERY_REF, "beliefs"): self._beliefs,
            **{(Performative.QUERY_REF, topic): self._look for topic in ("seen", "held", "place")},
            **{(Performative.QUERY_IF, topic): self._look for topic in ("sees", "holds")},
        }
        """By performative and name of the content's term."""

    @property
    def needs(self) -> Needs:
        """The sensors that open questions need."""
        return LOCATING if self._looks else NOTHING

    def memory(self) -> tuple[PersonsRequestMemory, ...]:
        """For another program that goes on with them."""
        running = [
            PersonsRequestMemory(message=heard.message, at_s=heard.at_s, script=script)
            for script, heard in self._running
        ]
        looks = [
            PersonsRequestMemory(message=one.asked.message, at_s=one.asked.at_s, until_s=one.until_s)
            for one in self._looks
        ]
        return (*running, *looks)

    def recall(self, requests: Iterable[tuple[PersonsRequestMemory, Heard]]) -> None:
        """Go on with them; each with what was heard, understood again."""
        for one, heard in requests:
            if one.script is not None:
                self._running.append((one.script, heard))
            else:
                self._looks.append(_Look(heard, one.until_s))

    def step(self, robot: Situated, now_s: float) -> None:
        """Say of what was asked for how it has ended, and answer questions whose readings have come."""
        for script, heard in list(self._running):
            if not self._is_open(heard):
                self._running.remove((script, heard))
                robot.withdraw(script.id)  # cancelled, or the person no longer waits for it
            elif robot.state_of(script.id) in ENDED:
                self._running.remove((script, heard))
                self._answer(heard, _ending(script, robot))
        self._looks = [look for look in self._looks if self._is_open(look.asked)]
        for look in list(self._looks):
            percepts = robot.percepts
            if percepts is not None and percepts.data.holds(LOCATING) and percepts.time_s >= look.asked.at_s:
                self._looks.remove(look)
                self._answer(look.asked, _inform(_sighted(look.asked.content, percepts)))
            elif now_s >= look.until_s:
                self._looks.remove(look)
                content = Term("failed", (look.asked.content, f"no reading within {LOOK_S:g} s"))
                self._answer(look.asked, Reply(performative=Performative.FAILURE, content=content))

    def _perform(self, heard: Heard, robot: Situated) -> Reply:
        try:
            script = leg_of(heard.content, self._name)
        except ContentError as error:
            return Reply(
                performative=Performative.NOT_UNDERSTOOD, content=Term("reason", (str(error)[:300],))
            )
        script = script.model_copy(update={"id": f"{SAID}{script.id}", "mission_id": OWN})
        if script.id in self._halted:
            return Reply(performative=Performative.REFUSE, content=Term("refused", ("it was withdrawn",)))
        # NOTE: after a power failure the request is repeated, and must not be carried out twice.
        if robot.state_of(script.id) is None and (reason := robot.perform(script)) is not None:
            return Reply(performative=Performative.REFUSE, content=Term("refused", (reason,)))
        self._running.append((script, heard))
        return Reply(performative=Performative.AGREE, content=Term("agreed", (_told_id(script),)))

    def _halt(self, heard: Heard, robot: Situated) -> Reply:
        """End the script that is named, which spares what was asked for since; or whichever a person has asked for."""
        if not heard.content.args:
            reason = robot.halt(SAID)
        else:
            named = heard.content.words[0]
            script_id = f"{SAID}{named}"
            self._halted.append(script_id)
            state = robot.state_of(script_id)
            reason = f"{self._name} is not at {named}" if state is None or state in ENDED else None
            robot.withdraw(script_id)
        if reason is not None:
            return Reply(performative=Performative.REFUSE, content=Term("refused", (reason,)))
        return _inform(Term("halted"))

    def _look(self, heard: Heard, robot: Situated) -> Reply:
        self._looks.append(_Look(heard, heard.at_s + LOOK_S))
        return Reply(performative=Performative.AGREE, content=heard.content)

    def _position(self, heard: Heard, robot: Situated) -> Reply:
        percepts = robot.percepts
        if percepts is None:
            return _no_reading()
        pose = percepts.pose
        figures = {"x": pose.x_m, "y": pose.y_m, "heading": pose.heading_rad}
        near = [name for name in percepts.profile.places if _is_near(percepts, name)]
        parts = [Term(name, (round(value, 2),)) for name, value in figures.items()]
        return _inform(Term("position", (*parts, *(Term("near", (name,)) for name in near[:1]))))

    def _battery(self, heard: Heard, robot: Situated) -> Reply:
        percepts = robot.percepts
        if percepts is None:
            return _no_reading()
        charging: tuple[Argument, ...] = (Term("charging"),) if percepts.charging else ()
        return _inform(Term("battery", (round(percepts.battery, 3), *charging)))

    def _activity(self, heard: Heard, robot: Situated) -> Reply:
        return _inform(Term("activity", robot.activity or ("nothing",)))

    def _beliefs(self, heard: Heard, robot: Situated) -> Reply:
        return _inform(_newest_beliefs(robot.beliefs[-MAX_NAMED:]))


def perform_of(script: str, packets: Sequence[BehaviourPacket]) -> Term:
    """The content of a request for packets, each with the time that it may take."""
    timed = [one.model_copy(update={"expected_duration_s": one.timeout_s}) for one in packets]
    return Term(PERFORM, call_of(script, timed).args)


def of_person(act: SpeechAct, sender: str, service: str) -> bool:
    """True for what the service says on a person's behalf."""
    return bool(act.speaker) and sender == service


def _sighted(asked: Term, percepts: Percepts) -> Term:
    """What is answered to a question about what is seen or held."""
    held = percepts.holding
    about = asked.words[0] if asked.words else ""
    match asked.name:
        case "seen":
            return Term("seen", tuple(_in_view(percepts)))
        case "held":
            return Term("held", (held or "nothing",))
        case "sees":
            return _if(asked, percepts.sees(about))
        case "holds":
            return _if(asked, held == about)
        case _:
            at = percepts.locate(about)
            if at is None:
                return Term("not", (Term("seen", (about,)),))
            pose = percepts.pose
            point = complex(pose.x_m, pose.y_m) + at * rect(1.0, pose.heading_rad)
            return Term("place", (about, round(point.real, 2), round(point.imag, 2)))


def _newest_beliefs(beliefs: Sequence[str]) -> Term:
    """As many of the last ones as one message holds."""
    content = Term("beliefs", tuple(beliefs))
    while len(str(content)) > MAX_CONTENT:
        content = Term("beliefs", content.args[1:])
    return content


def _in_view(percepts: Percepts) -> Iterator[str]:
    """Samples first, then robots and places, each the nearest first."""
    places = percepts.profile.places
    seen = [one for one in percepts.sightings.values() if one.identity != percepts.holding]
    others = percepts.profile.others
    ranked = sorted(
        seen, key=lambda one: (one.identity in places, one.identity in others, one.range_m, one.identity)
    )
    return (one.identity for one in ranked[:MAX_NAMED])


def _if(asked: Term, holds: bool) -> Term:
    return asked if holds else Term("not", (asked,))


def _is_near(percepts: Percepts, place: str) -> bool:
    at = percepts.profile.places[place].point
    return abs(complex(percepts.pose.x_m, percepts.pose.y_m) - at) <= NEAR_M


def _ending(script: BehaviourScript, robot: Situated) -> Reply:
    state = robot.state_of(script.id)
    if state is ScriptState.FINISHED:
        return _inform(Term("done", (_told_id(script),)))
    reason = robot.why_ended(script.id) or f"it has {state}"
    return Reply(performative=Performative.FAILURE, content=Term("failed", (_told_id(script), reason[:300])))


def _told_id(script: BehaviourScript) -> str:
    return script.id.removeprefix(SAID)


def _inform(content: Term) -> Reply:
    return Reply(performative=Performative.INFORM, content=content)


def _no_reading() -> Reply:
    return Reply(performative=Performative.FAILURE, content=Term("failed", ("it senses nothing now",)))
