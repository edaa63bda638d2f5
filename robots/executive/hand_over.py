"""A mind as a document that one program writes and another one takes up: versioned, in pieces for the link."""

import json
from collections.abc import Iterator
from hashlib import sha256

from pydantic import ConfigDict, ValidationError

from robots.data import Checked
from robots.errors import RobotError
from robots.executive.memory import AgentMind
from robots.physical.body import Pose
from robots.wire import MAX_PIECE, MindPiece

VERSION = 1
"""Of the document. A program takes no other one."""
NEAR_M = 1.0
"""A script that has begun goes on in a body within this of where its former body stood (our choice)."""


class MindUnfit(RobotError):
    """Raised when a program cannot take a mind; says why."""


class MindDocument(Checked):
    """A mind at rest. `fence`: of the move that it is written for; `at_s`: by the world's clock; `stood`: where its
    body believed to stand, world frame, None if it did not know.
    """

    model_config = ConfigDict(extra="ignore")
    version: int = VERSION
    robot: str
    fence: int
    at_s: float
    stood: Pose | None = None
    mind: AgentMind


def read_document(text: str) -> MindDocument:
    """:raises MindUnfit: if the text is no document of this version."""
    try:
        said = json.loads(text)
    except ValueError as error:
        raise MindUnfit(f"the mind's document is no JSON: {error}") from error
    version = said.get("version") if isinstance(said, dict) else None
    if version != VERSION:
        raise MindUnfit(f"the mind's document is of version {version}; this program takes version {VERSION}")
    try:
        return MindDocument.model_validate_json(text)
    except ValidationError as error:
        fault = error.errors()[0]
        where = ".".join(map(str, fault["loc"]))
        raise MindUnfit(f"the mind's document cannot be read: {where}: {fault['msg']}") from error


def pieces_of(text: str, *, size: int = MAX_PIECE) -> list[MindPiece]:
    """The text in pieces of at most this number of characters."""
    digest = digest_of(text)
    parts = [text[start : start + size] for start in range(0, len(text), size)] or [""]
    return [
        MindPiece(number=number, count=len(parts), digest=digest, text=part)
        for number, part in enumerate(parts)
    ]


def digest_of(text: str) -> str:
    return sha256(text.encode()).hexdigest()


class Pieces:
    """The pieces of one document that have come."""

    def __init__(self) -> None:
        self._of: tuple[str, int] = ("", 0)
        self._texts: dict[int, str] = {}

    def put(self, piece: MindPiece) -> str | None:
        """Add a piece; the whole text once all have come. A piece of another document ends those before.

        :raises MindUnfit: if the pieces do not make the text that their digest is of.
        """
        if (piece.digest, piece.count) != self._of:
            self._of = (piece.digest, piece.count)
            self._texts = {}
        if piece.number < piece.count:
            self._texts[piece.number] = piece.text
        if len(self._texts) < piece.count:
            return None
        text = "".join(self._in_order())
        if digest_of(text) != piece.digest:
            self._texts = {}
            raise MindUnfit("the pieces of the mind's document do not fit together")
        return text

    def _in_order(self) -> Iterator[str]:
        return (self._texts[number] for number in sorted(self._texts))
