"""The ends of holds in sentences: "until 14:30", "for ten minutes", "until sample_1 is in door_2"."""

from dataclasses import replace

from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.kept_facts import HoldFact
from app.domain.goal_language.references import References
from app.domain.goal_language.sentence import Part, Phrase, Tail
from app.domain.goal_language.stated_holds import HoldEnd
from app.domain.goal_language.times import GOAL, MISSION, Times, in_words, next_full_hours, next_time_of_day
from app.domain.goal_language.verbs import Kind
from app.domain.goal_language.words import joined, name_in
from app.domain.world_model.beliefs import IN, NEAR, VACANT

FURTHER_NOTICE = ("further", "notice")
"""The words of a hold that an operator ends."""
SPANS = ("ten minutes", "half an hour", "two hours")
UNITS = ("minutes", "hours", "seconds")


def hold_end(tail: Tail, text: str, names: References, times: Times) -> tuple[HoldEnd, str] | Clarification:
    """The end that a phrase after "until" or "for" says, and what it was resolved to in words.

    :param text: the sentence.
    """
    end = _lasting(tail, text) if tail.part is Part.LASTING else _until(tail, text, names, times)
    if isinstance(end, Clarification):
        return end
    if end.at is None or times.now is None:
        return end, end.words
    return end, f"{end.words}, in {in_words((end.at - times.now).total_seconds())}"


def _until(tail: Tail, text: str, names: References, times: Times) -> HoldEnd | Clarification:
    phrase = tail.phrase
    first = phrase.words[0] if phrase.words else ""
    end: HoldEnd | Clarification = _until_when(tail, times)
    if tail.time and times.now is not None:
        end = HoldEnd(at=next_time_of_day(tail.time, times.now))
    elif tail.place is not None or tail.says_empty:
        fact = _fact(phrase, tail, replace(names, mentioned=set(names.mentioned)))
        end = fact if isinstance(fact, Clarification) else HoldEnd(fact=fact)
    elif phrase.words == FURTHER_NOTICE:
        end = HoldEnd()
    elif first.startswith(MISSION):
        mission = times.mission(phrase, text)
        end = mission if isinstance(mission, Clarification) else HoldEnd(mission=mission)
    elif first.startswith(GOAL):
        goal = times.goal(phrase, text)
        end = goal if isinstance(goal, Clarification) else HoldEnd(goal=goal)
    elif first and tail.says_is:
        end = _where(tail, text, names)
    return end


def _where(tail: Tail, text: str, names: References) -> Clarification:
    """The question where a sample or robot is to be: "until sample_1 is in"."""
    is_robot = name_in(tail.phrase.words, names.robots) in names.robots
    end = tail.span[1]
    return Clarification(
        code="place-needed",
        detail=f"until {text[slice(*tail.phrase.span)]} is where?",
        choices=names.locations if is_robot else names.holding(),
        span=(end, end),
        link="in" if text[:end].endswith("is") else "",
    )


def _lasting(tail: Tail, text: str) -> HoldEnd | Clarification:
    if tail.seconds > 0:
        return HoldEnd(in_s=tail.seconds)
    is_zero = tail.has_unit
    choices = UNITS if tail.has_number else SPANS
    return Clarification(
        code="time-not-understood",
        detail="for how long? Say a span, such as for ten minutes",
        thing=text[slice(*tail.span)] if is_zero else "",
        choices=tuple(f"for {span}" for span in SPANS) if is_zero else choices,
        span=tail.span if is_zero else (tail.span[1], tail.span[1]),
    )


def _until_when(tail: Tail, times: Times) -> Clarification:
    phrase = tail.phrase
    return Clarification(
        code="time-not-understood",
        detail="until when? Say a time, such as 14:30, a mission or goal that ends, further notice, or a fact, "
        "such as sample_1 is in door_2",
        thing=phrase.said,
        choices=(
            *(next_full_hours(times.now) if times.now else ()),
            *times.missions(),
            *times.goals(),
            " ".join(FURTHER_NOTICE),
        ),
        span=phrase.span if phrase.words else (tail.span[1], tail.span[1]),
    )


def _fact(phrase: Phrase, tail: Tail, names: References) -> HoldFact | Clarification:
    """The fact "sample_1 is in door_2", "yard_1 is at door_1" or "bay_4 is empty"."""
    if tail.says_empty:
        place = names.place(phrase)
        return place if isinstance(place, Clarification) else HoldFact(predicate=VACANT, args=(place,))
    is_robot = name_in(phrase.words, names.robots) in names.robots
    found = names.things(Kind.ROBOT if is_robot else Kind.SAMPLE, phrase, "until", None)
    if isinstance(found, Clarification):
        return found
    if len(found) != 1:
        detail = f"until one of them is there; say which: {joined(found, last='or')}"
        return Clarification(
            code="sample-needed", detail=detail, thing=phrase.said, choices=found, span=phrase.span
        )
    assert tail.place is not None
    place = names.place(tail.place, names.locations if is_robot else ())
    if isinstance(place, Clarification):
        return place
    return HoldFact(predicate=NEAR if is_robot else IN, args=(found[0], place))
