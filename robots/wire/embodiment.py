"""The messages by which the service has a robot's mind rest, go on, and move from one program to another."""

from typing import Literal

from pydantic import Field

from robots.data import StrEnum
from robots.wire.script import Wire

MAX_PIECE = 200_000
"""Characters of a mind's document in one message."""
MAX_PIECES = 1000


class MindVerb(StrEnum):
    """What a robot's mind is to do."""

    REST = "rest"
    """Stand still at a safe point, and do nothing until it is told to go on."""
    GO_ON = "go_on"
    """Go on from there."""


class Program(StrEnum):
    """Which of the two programs that may have a robot's mind is meant."""

    WORLD = "world"
    """The simulation of its world."""
    OWN = "own"
    """The robot's own software."""


class MindPiece(Wire):
    """A piece of a mind's document, the text of `MindDocument` as JSON.

    `number` counts from 0, `count`: of all pieces; `digest`: SHA-256 of the whole text in UTF-8, by which pieces belong
    together.
    """

    number: int = Field(ge=0, lt=MAX_PIECES)
    count: int = Field(ge=1, le=MAX_PIECES)
    digest: str = Field(min_length=64, max_length=64)
    text: str = Field(max_length=MAX_PIECE)


class MindOrder(Wire):
    """Service to robot: let your mind rest before it gets another body, or go on (request).

    `fence`: the fencing number; one lower than that of an order followed before is refused. `within_s`: a mind that
    has not come to rest in this time refuses. `lease_until_s`: of a mind that goes on, until when, by the world's
    clock: then it rests by itself, unless it is told a later time under the same number; None: without end.
    `to`: the program that is meant, which alone follows and answers; None: whichever speaks for the robot.
    `piece`: of a mind that is to rest, the number of the piece of its document that the answer is to bring: the mind is
    handed over to another program, and this one says and does nothing more until it is told to go on. None: it stays
    in its program.
    """

    kind: Literal["mind_order"] = "mind_order"
    verb: MindVerb
    fence: int = Field(ge=1)
    within_s: float = Field(default=30.0, gt=0)
    lease_until_s: float | None = None
    to: Program | None = None
    piece: int | None = Field(default=None, ge=0, lt=MAX_PIECES)


class MindOrderReport(Wire):
    """Robot to service: the mind rests, or goes on (agree), or does not for a reason (refuse).

    `lease_until_s`: of a mind that goes on, until when, as it was told. `mind`: of one that rests and is handed over.
    """

    kind: Literal["mind_order_report"] = "mind_order_report"
    verb: MindVerb
    fence: int
    reason: str = ""
    lease_until_s: float | None = None
    mind: MindPiece | None = None


class MindTransfer(Wire):
    """Service to the robot's own software: take this piece of the mind that another program hands over (request).

    With the last piece the mind is taken up, at rest and silent, until it is told to go on under this fencing number.
    """

    kind: Literal["mind_transfer"] = "mind_transfer"
    fence: int = Field(ge=1)
    mind: MindPiece


class MindTransferReport(Wire):
    """The robot's own software to service: it has this piece (agree), or cannot take the mind for a reason (refuse)."""

    kind: Literal["mind_transfer_report"] = "mind_transfer_report"
    fence: int
    digest: str
    number: int
    reason: str = ""
