"""What a page shows reaches the view in three dimensions; what is picked there reaches that page alone."""

import json
from collections.abc import Iterator
from typing import Any

import pytest
from fastapi import FastAPI
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from app.api.page_views import MAX_PICKS, PageViews, Pick, Shown, views_router
from tests.app.serving import served
from tests.waiting import until

ONE, OTHER = "page-number-one", "page-number-two"
MOST = 3


@pytest.fixture
def views() -> PageViews:
    return PageViews()


@pytest.fixture
def host(views: PageViews) -> Iterator[str]:
    app = FastAPI()
    app.include_router(views_router(views, max_open=MOST))
    with served(app) as address:
        yield address.replace("http", "ws", 1)


def socket(host: str, view: str = "") -> ClientConnection:
    return connect(f"{host}/v1/views{view and '/'}{view}", proxy=None)


def say(to: ClientConnection, **body: object) -> None:
    to.send(json.dumps(body))


def heard(from_: ClientConnection) -> dict[str, Any]:
    message: dict[str, Any] = json.loads(from_.recv(timeout=10))
    return message


def told(view: ClientConnection) -> dict[str, Any]:
    message = heard(view)
    return {message["id"]: message["shown"] and Shown(**message["shown"]).model_dump(exclude_defaults=True)}


def test_what_a_page_shows_is_sent_at_first_and_whenever_it_changes(host: str, views: PageViews) -> None:
    with socket(host, ONE) as page:
        say(page, world="lab", robot="fred")
        until(lambda: views.shown(ONE))
        with socket(host) as view:
            assert told(view) == {ONE: {"world": "lab", "robot": "fred"}}
            say(page, world="lab", replay={"mission_id": "m", "time_s": 3.5})
            assert told(view) == {ONE: {"world": "lab", "replay": {"mission_id": "m", "time_s": 3.5}}}
            page.close()
            assert told(view) == {ONE: None}
    assert not views.ids


def test_a_pick_reaches_its_own_page_alone(host: str) -> None:
    with (
        socket(host, ONE) as one,
        socket(host, OTHER) as other,
        socket(host) as view,
    ):
        pick = {"kind": "sample", "name": "sample_3"}
        say(view, id=ONE, pick=pick)
        say(view, id=OTHER, pick=pick | {"name": "sample_4"})
        assert heard(one) == pick
        assert heard(other) == pick | {"name": "sample_4"}


def test_a_page_that_comes_again_takes_the_place_of_its_lost_connection(host: str, views: PageViews) -> None:
    with socket(host, ONE) as lost, socket(host, ONE) as again:
        say(again, world="lab")
        until(lambda: views.shown(ONE))
        say(lost, world="old")
        lost.close()
        with socket(host) as view:
            assert told(view) == {ONE: {"world": "lab"}}


@pytest.mark.parametrize(
    "frame",
    ["nonsense", json.dumps({"world": 3}), '{"replay": {"mission_id": "m", "time_s": NaN}}', "1" * 5000],
)
def test_what_is_not_understood_ends_the_connection(host: str, views: PageViews, frame: str) -> None:
    with socket(host, ONE) as page:
        page.send(frame)
        with pytest.raises(ConnectionClosed) as refusal:
            page.recv(timeout=10)
    assert refusal.value.rcvd.code == 1008
    assert not views.ids


def test_picks_that_nobody_takes_and_picks_for_nobody_are_dropped(views: PageViews) -> None:
    pick = Pick(kind="robot", name="fred")
    views.pick(ONE, pick)
    with views.page(ONE) as page:
        for _ in range(2 * MAX_PICKS):
            views.pick(ONE, pick)
        assert page.picks.qsize() == MAX_PICKS


def test_only_so_many_may_be_connected_and_one_that_leaves_makes_room(host: str, views: PageViews) -> None:
    pages = [socket(host, f"page-number-{number}") for number in range(MOST)]
    until(lambda: len(views.ids) == MOST)
    with socket(host) as refused, pytest.raises(ConnectionClosed) as refusal:
        refused.recv(timeout=10)
    assert refusal.value.rcvd.code == 1013
    for page in pages:
        page.close()
    until(lambda: not views.ids)
    with socket(host, ONE) as page, socket(host) as view:
        say(page, robot="fred")
        while (now := told(view)) == {ONE: None}:
            pass
        assert now == {ONE: {"robot": "fred"}}
