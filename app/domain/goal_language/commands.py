"""The clauses of a sentence as commands: what continues the clause before is joined to it."""

from collections.abc import Sequence

from app.domain.goal_language.clarification import Clarification
from app.domain.goal_language.sentence import ENDS, LISTS, Clause, Part, Tail
from app.domain.goal_language.verbs import Role, Verbs
from app.domain.goal_language.words import joined, suggestions


def commands_of(clauses: Sequence[Clause], verbs: Verbs) -> list[Clause] | Clarification:
    """The clauses as whole commands: what continues the clause before is joined to it."""
    commands: list[Clause] = []
    for clause in clauses:
        last = commands[-1] if commands else None
        if clause.verb or clause.is_keep:
            commands.append(clause)
        elif clause.is_keep_on and last is not None and last.is_keep and last.says_end:
            clause.is_keep = True  # "keep bay_3 empty until 14:30 and bay_4 empty until 15:00"
            commands.append(clause)
        elif _keeps_more(last, clause):
            assert last is not None
            clause.is_keep = True  # "keep sample_1 in bay_7 and sample_2 in bay_3"
            clause.continues_keep = True
            clause.is_preferred = last.is_preferred
            commands.append(clause)
        elif clause.is_keep_on or _lacks_empty(last, clause):
            if last is None or not last.is_keep:
                return _unknown_verb(clause, verbs)
            _join(last, clause)
        elif last is None and not clause.objects and not clause.names_place:
            commands.append(clause)  # constraints that come first
        elif last is not None and _is_continued(last, clause, verbs):
            _join(last, clause)
        elif verb := next((c.verb for c in reversed(commands) if c.verb), ""):
            clause.verb = verb
            commands.append(clause)
        else:
            return _unknown_verb(clause, verbs)
    return _with_ends_before(_with_ends_after(commands))


def _with_ends_before(commands: list[Clause]) -> list[Clause]:
    """The commands, with an end that is said first joined to what it is the end of: "until 14:30, keep bay_3 empty"."""
    first = commands[0] if commands else None
    if first is None or first.verb or first.is_keep or not first.says_end or len(commands) < 2:
        return commands
    if commands[1].is_keep and not commands[1].says_end:
        commands[1].tails.extend(tail for tail in first.tails if tail.part in ENDS)
        first.tails = [tail for tail in first.tails if tail.part not in ENDS]
    return commands


def _keeps_more(last: Clause | None, clause: Clause) -> bool:
    """True if the clause names another thing and the place where it is kept."""
    return (
        last is not None
        and last.keeps_facts
        and bool(clause.objects)
        and any(tail.part is Part.TARGET for tail in clause.tails)
    )


def _with_ends_after(commands: list[Clause]) -> list[Clause]:
    """The commands, with an end that is said last said of all that one "keep" keeps."""
    for before, clause in zip(reversed(commands[:-1]), reversed(commands), strict=False):
        if clause.continues_keep and not before.says_end:
            before.tails.extend(tail for tail in clause.tails if tail.part in ENDS)
    return commands


def _lacks_empty(last: Clause | None, clause: Clause) -> bool:
    """True if the clause is a place between "keep" and "empty": "keep bay_1, bay_2 and bay_3 empty"."""
    return (
        last is not None and last.is_keep and not last.says_empty and not last.tails and bool(clause.objects)
    )


def _is_continued(last: Clause, clause: Clause, verbs: Verbs) -> bool:
    """True if a clause without a verb adds to the one before instead of stating another goal."""
    if not clause.objects:
        return not clause.names_place
    if last.tails and last.tails[-1].part in LISTS and not clause.names_place:
        return True
    if last.verb and not last.is_keep and not last.names_place:
        verb = verbs.by_word[last.verb]
        has_partner = len(last.objects) > 1 or last.phrases(Part.WITH)
        if verb.slot(Role.PARTNER) is not None:
            return not has_partner
        return verb.needs_target
    return False


def _unknown_verb(clause: Clause, verbs: Verbs) -> Clarification:
    first = clause.first
    words = verbs.words
    near = suggestions(first, words)
    detail = f"{first!r} is not a known verb" + (f"; did you mean {joined(near)}?" if near else "")
    return Clarification(
        code="unknown-verb", detail=detail, thing=first, choices=near or words, span=clause.first_span
    )


def _join(last: Clause, clause: Clause) -> None:
    """Add a clause that continues the last one to it."""
    if last.tails and last.tails[-1].part in LISTS and not clause.names_place:
        listed = last.tails[-1]
        last.tails.extend(
            Tail(
                part=listed.part,
                phrase=phrase,
                span=phrase.span,
                is_preferred=listed.is_preferred,
                is_more=True,
            )
            for phrase in clause.objects
        )
    else:
        last.objects.extend(clause.objects)
        last.says_empty = last.says_empty or clause.says_empty
    last.tails.extend(clause.tails)
    last.span = (last.span[0], clause.span[1])
