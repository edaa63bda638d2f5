"""Words of a sentence and a world's names in them: `Sample 3` and `sample-3` are `sample_3`."""

import re
import unicodedata
from collections.abc import Iterable, Sequence
from difflib import get_close_matches

ARTICLES = frozenset({"the", "a", "an"})


def words_of(text: str) -> tuple[str, ...]:
    """Lower-case words without articles and punctuation; a hyphen binds like an underscore.

    Every other character belongs to its word: a digit of another script (`sample_1０`) must not be lost from a name.
    """
    spaced = "".join(" " if _separates(character) else character for character in text.lower())
    found = (word.strip("-").replace("-", "_") for word in spaced.split())
    return tuple(word for word in found if word and word not in ARTICLES)


def name_in(words: Sequence[str], names: Iterable[str]) -> str:
    """The name that the words spell, ignoring underscores; if there is none, the words joined by underscores."""
    known = tuple(names)
    joined = "_".join(words)
    if joined in known:
        return joined
    return next((name for name in known if _plain(name) == _plain(joined)), joined)


def suggestions(name: str, names: Iterable[str], *, limit: int = 3) -> tuple[str, ...]:
    """Near misses, best first."""
    return tuple(get_close_matches(name, sorted(names), n=limit, cutoff=0.6))


def choices_for(name: str, names: Iterable[str]) -> tuple[str, ...]:
    """All names, near misses first, and numbers in their natural order."""
    near = suggestions(name, names)
    return (*near, *sorted(set(names) - set(near), key=natural_key))


def natural_key(name: str) -> tuple[str | int, ...]:
    """Sort key that orders bay_2 before bay_10."""
    parts = re.split("([0-9]{1,18})", name)
    return tuple(int(part) if index % 2 else part for index, part in enumerate(parts))


def joined(names: Sequence[str], *, last: str = "or") -> str:
    """`a, b or c`."""
    if not names:
        return "none"
    if len(names) == 1:
        return names[0]
    return f"{', '.join(names[:-1])} {last} {names[-1]}"


def _plain(name: str) -> str:
    """Without underscores, except those between digits: `sample 1 0` is not `sample_10`."""
    return re.sub(r"(?<![0-9])_|_(?![0-9])", "", name)


def _separates(character: str) -> bool:
    """True for white space and punctuation except hyphens and underscores."""
    return character.isspace() or (character not in "-_" and unicodedata.category(character).startswith("P"))
