"""Routes of persons' words to single robots: what is said, the robot's questions, approval, and how it ended."""

from typing import Any, Self

from fastapi import APIRouter
from pydantic import BaseModel, Field

from app.api.bodies import Decision, Page, Request
from app.api.goals import ACTOR
from app.api.parameters import After, Id, IdempotencyKey, Limit
from app.api.problems import declared
from app.api.services import AppServices
from app.api.worlds import TAGS
from app.domain.lifecycles.dialogue import DialogueState
from app.missions.dialogues import Word
from app.store import DialogueRow
from robots.wire import Performative

MAX_TEXT = 500


class SayWord(Request):
    """A sentence of the restricted language, or a line of FIPA ACL."""

    text: str = Field(
        min_length=1,
        max_length=MAX_TEXT,
        examples=["yard_2, face sample_1", "REQUEST target:yard_2 action:face object:sample_1"],
    )
    dialogue: str | None = Field(
        default=None,
        max_length=120,
        description="the dialogue that it goes on with, such as the answer to which one",
    )
    approve: bool = Field(
        default=False, description="carry out at once what it asks for, without showing it first"
    )


class DialogueLine(BaseModel):
    """What the person or the robot has said, as an act with its content, and in words."""

    by: str
    performative: Performative
    content: str
    words: str
    at: str


class DialogueQuestion(BaseModel):
    """What the person is asked; the answer is one of the choices, "the left one" or "the second"."""

    detail: str
    choices: list[str]


class ShownPacket(BaseModel):
    """A packet of the script that waits for approval, or was approved."""

    tag: str
    arguments: dict[str, str]
    expected_duration_s: float
    timeout_s: float


class DialogueBody(BaseModel):
    """What a person says to one robot, from the first word to how it ended."""

    id: str
    robot: str
    world: str
    state: DialogueState
    reason: str = Field(description="why it is refused, has failed or was withdrawn")
    text: str = Field(
        description="what was said, with what was answered to the robot's questions in its place"
    )
    question: DialogueQuestion | None
    script: list[ShownPacket]
    lines: list[DialogueLine] = Field(description="oldest first")
    said_by: str
    created_at: str

    @classmethod
    def of(cls, row: DialogueRow) -> Self:
        known: dict[str, Any] = {name: getattr(row, name) for name in _COLUMNS}
        question = row.asked if row.state == DialogueState.ASKING else None
        return cls.model_validate({**known, "question": question, "script": row.packets})


_COLUMNS = ("id", "robot", "world", "state", "reason", "text", "lines", "said_by", "created_at")


def dialogues_router() -> APIRouter:
    router = APIRouter(prefix="/v1/robots/{name}/dialogues", tags=TAGS)

    @router.post("", status_code=202, responses=declared(404, 409))
    def say(
        services: AppServices, name: Id, body: SayWord, idempotency_key: IdempotencyKey = None
    ) -> DialogueBody:
        """Say something to one robot.

        What moves it becomes a script of its own, which is shown (`proposed`) and waits for `:approve`, unless
        `approve` is set. If several things may be meant, the state is `asking`; say the answer with `dialogue`. A robot
        on a mission, driven or out of service refuses; `stop` pauses its mission. Its answers come later: read the
        dialogue again, or follow the events `dialogue.*`. 422 names the word that is not understood, and what would
        be, or says that no message holds it (`too-long-to-say`).
        """
        word = Word(text=body.text, dialogue=body.dialogue, approve=body.approve, key=idempotency_key)
        return DialogueBody.of(services.dialogues.say(name, word, actor=ACTOR))

    @router.get("", responses=declared(404))
    def list_dialogues(
        services: AppServices, name: Id, limit: Limit = 100, after: After = None
    ) -> Page[DialogueBody]:
        """The robot's dialogues, newest first."""
        rows, token = services.dialogues.newest(name, limit=limit, after=after)
        return Page(items=[DialogueBody.of(row) for row in rows], next=token)

    @router.get("/{dialogue_id}", responses=declared(404))
    def get_dialogue(services: AppServices, name: Id, dialogue_id: Id) -> DialogueBody:
        return DialogueBody.of(services.dialogues.get(name, dialogue_id))

    @router.post("/{dialogue_id}:approve", status_code=202, responses=declared(404, 409))
    def approve(services: AppServices, name: Id, dialogue_id: Id) -> DialogueBody:
        """Have the robot carry out the script that is shown. 409 if none is."""
        return DialogueBody.of(services.dialogues.approve(name, dialogue_id, actor=ACTOR))

    @router.post("/{dialogue_id}:withdraw", status_code=202, responses=declared(404, 409))
    def withdraw(
        services: AppServices, name: Id, dialogue_id: Id, body: Decision | None = None
    ) -> DialogueBody:
        """Withdraw what was said; a script under way ends. 409 if it has ended."""
        comment = body.comment if body else ""
        return DialogueBody.of(services.dialogues.withdraw(name, dialogue_id, actor=ACTOR, comment=comment))

    return router
