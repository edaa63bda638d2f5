"""What a person's text asks of one robot: a script, to stop, or a speech act; or what to ask the person."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.words import name_in
from app.domain.robot_language.acl import AclLine, is_acl, parse_acl
from app.domain.robot_language.packets import Choice, choose, verbs_of
from app.domain.robot_language.references import WHICH_ONE, Kind, chosen, resolve
from app.domain.robot_language.sentence import Command, Phrase, Question, Topic
from app.domain.robot_language.surroundings import Surroundings
from app.domain.robot_language.syntax import NOT_UNDERSTOOD, parse, tokens_of
from robots.social import ContentError, Term, parse_term
from robots.social.persons import HALT, PERFORM
from robots.wire import BehaviourPacket, Performative

STOP = "STOP"
"""The packet that stands for the order to stop; it is not run as one, for it would not end what the robot is at."""
MAX_COMMANDS = 8
COMMAND_FIELDS = frozenset({"target", "action", "object", "to", "property", "content"})


@dataclass(frozen=True, slots=True, kw_only=True)
class Ordered:
    """The robot is asked to do these packets in order."""

    packets: tuple[BehaviourPacket, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Stopped:
    """The robot is asked to stop what it is at."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spoken:
    """Something else is said to the robot: a question, or what its rules may hear."""

    performative: Performative
    content: Term


Understood = Ordered | Stopped | Spoken


def understand(text: str, around: Surroundings) -> Understood | Clarification:
    """What the text asks of the robot, or what to ask the person."""
    if is_acl(text):
        line = parse_acl(text)
        return line if isinstance(line, Clarification) else _of_acl(line, text, around)
    parsed = parse(text, verbs_of(around), around.robots)
    if isinstance(parsed, Clarification):
        return parsed
    addressed, said = parsed
    if addressed and addressed != around.robot:
        return _other_robot(addressed, around, None)
    if isinstance(said, Question):
        return _question(said, around)
    return _ordered(said, around)


def answered(text: str, answer: str, asked: Clarification, around: Surroundings) -> str | None:
    """The text with what the person has answered to the question about it; None if it is no answer.

    :param text: about which `asked` asks.
    """
    choice = chosen(answer, asked.choices, around) if asked.code == WHICH_ONE else None
    if choice is None and is_acl(answer) and isinstance(line := parse_acl(answer), AclLine):
        choice = chosen(line.text("object") or line.text("to"), asked.choices, around)
    return None if choice is None else completed(text, asked, choice)


def completed(text: str, asked: Clarification, choice: str) -> str:
    """The text with one of the choices where the question points."""
    if asked.span is None:
        return text
    start, end = asked.span
    if start < end:
        return f"{text[:start]}{choice}{text[end:]}"
    link = asked.link if not asked.link or asked.link.endswith(":") else f"{asked.link} "
    return f"{text[:start].rstrip()} {link}{choice}{text[end:]}".strip()


def _ordered(commands: tuple[Command, ...], around: Surroundings) -> Ordered | Stopped | Clarification:
    packets: list[BehaviourPacket] = []
    it: str | None = None
    if len(commands) > MAX_COMMANDS:
        return Clarification(code="too-many-commands", detail=f"at most {MAX_COMMANDS} at a time")
    for number, command in enumerate(commands, start=1):
        made = choose(command, around, number=number, it=it)
        if not isinstance(made, Choice):
            return made
        if made.packet.tag == STOP:
            if len(commands) == 1:
                return Stopped()
            detail = "say stop alone: it ends what the robot is at"
            return Clarification(code=NOT_UNDERSTOOD, detail=detail, thing=command.verb, span=command.span)
        packets.append(made.packet)
        it = made.it
        around = replace(around, holding=made.holding)
    starts_s = 0.0
    timed: list[BehaviourPacket] = []
    for one in packets:
        timed.append(one.model_copy(update={"expected_start_s": starts_s}))
        starts_s += one.expected_duration_s
    return Ordered(packets=tuple(timed))


def _question(said: Question, around: Surroundings) -> Spoken | Clarification:
    if said.about is None:
        return Spoken(performative=Performative.QUERY_REF, content=Term(said.topic.value))
    about = resolve(said.about, Kind.THING, around, it=around.holding)
    if isinstance(about, Clarification):
        return about
    asks_where = said.topic is Topic.PLACE
    performative = Performative.QUERY_REF if asks_where else Performative.QUERY_IF
    return Spoken(performative=performative, content=Term(said.topic.value, (Term(about),)))


def _of_acl(line: AclLine, text: str, around: Surroundings) -> Understood | Clarification:
    target = line.fields.get("target")
    if target is not None and (name := name_in(_words(target), around.robots)) != around.robot:
        return _other_robot(name, around, target.span)
    action = " ".join(one.text for one in tokens_of(line.text("action").replace("_", " ")))
    tags = {spec.tag.lower().replace("_", " ") for spec in around.packets}
    if line.performative is Performative.REQUEST and action in verbs_of(around) | tags:
        return _ordered((_command(line, action, text),), around)
    if line.performative is Performative.QUERY_REF and len(line.properties) == 1 and not action:
        return Spoken(performative=line.performative, content=Term(line.properties[0]))
    return _spoken(line, around)


def _command(line: AclLine, action: str, text: str) -> Command:
    given: Mapping[str, Phrase] = {
        key: phrase for key, phrase in line.fields.items() if key not in COMMAND_FIELDS and phrase.words
    }
    return Command(
        verb=action,
        span=line.fields["action"].span,
        end=len(text.rstrip()),
        object=_named(line, "object"),
        target=_named(line, "to"),
        given=given,
        is_acl=True,
    )


def _named(line: AclLine, key: str) -> Phrase | None:
    phrase = line.fields.get(key)
    if phrase is None or not phrase.words:
        return None
    return replace(phrase, words=_words(phrase))


def _words(phrase: Phrase) -> tuple[str, ...]:
    return tuple(one.text for one in tokens_of(phrase.said)) or phrase.words


def _spoken(line: AclLine, around: Surroundings) -> Stopped | Spoken | Clarification:
    """The content that a line states, or that its action with object and properties makes."""
    stated = line.text("content")
    try:
        if stated:
            return _said(line, parse_term(stated), "content")
    except ContentError as error:
        return Clarification(
            code=NOT_UNDERSTOOD, detail=str(error), thing=stated, span=line.fields["content"].span
        )
    action = line.text("action")
    if not action:
        return Clarification(
            code=NOT_UNDERSTOOD,
            detail=f"a {line.performative.value} has an action: or a content:",
            choices=("action:", "content:"),
            span=line.span,
        )
    things = (line.text("object"), line.text("to"), *line.properties)
    return _said(line, Term(action, tuple(Term(one) for one in things if one)), "action")


def _said(line: AclLine, content: Term, key: str) -> Stopped | Spoken | Clarification:
    """What moves the robot is no mere word: it is to be shown, checked and approved. :param key: where it is stated."""
    if line.performative is Performative.REQUEST and content.name == HALT:
        return Stopped()
    if line.performative is Performative.REQUEST and content.name == PERFORM:
        return Clarification(
            code=NOT_UNDERSTOOD,
            detail=f"{PERFORM} is said for a script that was approved; say what the robot is to do by action:, "
            "such as REQUEST action:face object:sample_1",
            thing=PERFORM,
            choices=("action:",),
            span=line.fields[key].span,
        )
    return Spoken(performative=line.performative, content=content)


def _other_robot(name: str, around: Surroundings, span: tuple[int, int] | None) -> Clarification:
    return Clarification(
        code="other-robot",
        detail=f"this is {around.robot}; say it to {name} itself",
        thing=name,
        choices=(around.robot,),
        span=span,
    )
