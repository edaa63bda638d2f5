"""Words of a sentence and a world's names in them: `Sample 3` and `sample-3` are `sample_3`."""

import re
from collections.abc import Iterable, Sequence
from difflib import get_close_matches

ARTICLES = frozenset({"the", "a", "an"})


def words_of(text: str) -> tuple[str, ...]:
    """Lower-case words without articles and punctuation; a hyphen binds like an underscore."""
    found = re.findall(r"[a-z0-9_]+(?:-[a-z0-9_]+)*", text.lower())
    return tuple(word.replace("-", "_") for word in found if word not in ARTICLES)


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
    return tuple(int(part) if part.isdigit() else part for part in re.split(r"(\d+)", name))


def joined(names: Sequence[str], *, last: str = "or") -> str:
    """`a, b or c`."""
    if not names:
        return "none"
    if len(names) == 1:
        return names[0]
    return f"{', '.join(names[:-1])} {last} {names[-1]}"


def _plain(name: str) -> str:
    return name.replace("_", "")
