"""`macta robot say`: a person's word to one robot of a running service."""

from typing import Any

import httpx2
import pytest

from app.cli.say import say
from app.domain.errors import Invalid


def told(state: str, *words: str, reason: str = "") -> dict[str, Any]:
    lines = [{"by": "administrator", "words": "hi"}, *({"by": "yard_2", "words": one} for one in words)]
    return {"id": "d1", "state": state, "reason": reason, "lines": lines}


def service(*answers: dict[str, Any], status: int = 200) -> httpx2.Client:
    """Answers one after the other; the last one again and again."""
    left = list(answers)

    def handle(request: httpx2.Request) -> httpx2.Response:
        assert request.url.path.startswith("/v1/robots/yard_2/dialogues")
        return httpx2.Response(status, json=left.pop(0) if len(left) > 1 else left[0])

    return httpx2.Client(base_url="http://service", transport=httpx2.MockTransport(handle))


def said(client: httpx2.Client, **more: Any) -> list[str]:
    wanted = {"approve": False, "patience_s": 2.0, "pause": lambda _: None} | more
    return list(say(client, "yard_2", "face the sample", **wanted))


def test_what_the_robot_says_is_printed_until_it_is_done() -> None:
    client = service(told("said"), told("agreed", "yes, I do"), told("done", "yes, I do", "done"))
    assert said(client, approve=True) == ["yard_2: yes, I do", "yard_2: done", "dialogue d1 is done"]


def test_a_question_and_a_script_say_how_to_go_on() -> None:
    assert said(service(told("asking", "which one?")))[-1].endswith("answer with --dialogue d1")
    assert "say yes with --dialogue d1" in said(service(told("proposed", "I would")))[-1]


def test_the_reason_of_a_refusal_is_printed_and_a_problem_is_an_error() -> None:
    assert said(service(told("refused", "no: busy", reason="busy")))[-1] == "dialogue d1 is refused: busy"
    with pytest.raises(Invalid, match="did you mean face"):
        said(service({"detail": "'fase' cannot stand here; did you mean face?"}, status=422))


def test_a_robot_that_is_long_at_it_is_not_awaited_for_ever() -> None:
    assert said(service(told("agreed", "yes, I do")))[-1] == "dialogue d1 is agreed"
