"""What a robot answers, in words for a person."""

from math import degrees

from app.domain.goal_language.words import joined
from robots.social import Term
from robots.wire import Performative


def in_words(performative: Performative, content: Term) -> str:  # noqa: PLR0911
    """A sentence for an answer; the content itself for what is no answer of persons' requests."""
    words = content.words
    if performative is Performative.NOT_UNDERSTOOD:
        return f"I do not understand: {words[0] if words else content}"
    if performative is Performative.REFUSE:
        return f"no: {words[-1] if words else content}"
    if performative is Performative.FAILURE:
        return f"I could not: {words[-1] if words else content}"
    if performative is Performative.AGREE:
        return {"agreed": "yes, I do", "seen": "I look", "held": "I look"}.get(
            content.name, f"yes: {content}"
        )
    if performative is Performative.CONFIRM:
        return f"my rules have heard {content}"
    try:
        return _informed(content) if performative is Performative.INFORM else str(content)
    except IndexError:  # software of a third party leaves an argument out
        return str(content)


def _informed(content: Term) -> str:  # noqa: PLR0911, PLR0912
    words = content.words
    match content.name, content.args:
        case "done", _:
            return "done"
        case "halted", _:
            return "I have stopped"
        case "seen", ():
            return "I see nothing that I know"
        case "seen", _:
            return f"I see {joined(words, last='and')}"
        case "battery", (float(share), *rest):
            return f"my battery is at {share:.0%}" + (", and I charge" if rest else "")
        case "held", _:
            return f"I hold {words[0]}"
        case "holds" | "sees", _:
            return f"yes, I {'hold' if content.name == 'holds' else 'see'} {words[0]}"
        case "not", (Term(name=name, args=_) as inner,):
            return f"no, I do not {'hold' if name == 'holds' else 'see'} {', '.join(inner.words)}"
        case "activity", (Term(name="nothing"),):
            return "I do nothing"
        case "activity", _:
            return f"I am at {words[0]}, {words[1]}"
        case "abilities", _:
            return f"I can {joined(words, last='and')}"
        case "beliefs", ():
            return "I believe nothing"
        case "beliefs", _:
            return f"I believe {joined(words, last='and')}"
        case "place", (_, float(x_m), float(y_m)):
            return f"{words[0]} is at ({x_m:g}, {y_m:g})"
        case "position", _:
            return _position(content)
        case _:
            return str(content)


def _position(content: Term) -> str:
    parts = {one.name: one for one in content.args if isinstance(one, Term) and one.args}
    figures = {name: one.args[0] for name, one in parts.items()}
    x_m, y_m, heading_rad = (figures.get(name) for name in ("x", "y", "heading"))
    if not (isinstance(x_m, float) and isinstance(y_m, float) and isinstance(heading_rad, float)):
        return str(content)
    near = f", near {parts['near'].words[0]}" if "near" in parts else ""
    return f"I am at ({x_m:g}, {y_m:g}){near}, heading {degrees(heading_rad):.0f}°"
