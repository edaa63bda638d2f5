"""Signed messages: what its robot has said, once; and nothing else."""

from dataclasses import replace

import pytest

from robots.link.mqtt.session import Publication
from robots.link.mqtt.signature import SignatureCheck, Signer, signature_of

KEY = "a-key-of-fred"
SAID = Publication(topic="macta/v1/hall/fred/state", payload=b'{"at_s": 1}', run="run-1")


def signer(start: int = 100) -> Signer:
    return Signer(KEY, epoch_ns=lambda: start)


def test_what_a_robot_signs_is_accepted_in_order() -> None:
    check = SignatureCheck()
    sign = signer()
    assert [check.doubt(sign(SAID), KEY) for _ in range(3)] == ["", "", ""]


@pytest.mark.parametrize(
    "change",
    [
        {"payload": b'{"at_s": 2}'},
        {"topic": "macta/v1/hall/ginger/state"},
        {"run": "run-2"},
        {"counter": "101"},
        {"signature": "0" * 64},
        {"signature": "ä"},
        {"counter": ""},
        {"counter": "1" * 40},
        {"counter": "-1"},
        {"signature": ""},
    ],
)
def test_what_was_changed_is_not(change: dict[str, str]) -> None:
    assert SignatureCheck().doubt(replace(signer()(SAID), **change), KEY)  # type: ignore[arg-type]


def test_another_key_is_not_the_robots() -> None:
    assert "wrong signature" in SignatureCheck().doubt(Signer("another")(SAID), KEY)


def test_a_message_is_not_said_again_once_another_has_come() -> None:
    check = SignatureCheck()
    sign = signer()
    recorded, later = sign(SAID), sign(SAID)
    assert check.doubt(recorded, KEY) == ""
    assert check.doubt(recorded, KEY) == "", "the network delivers twice"
    assert check.doubt(later, KEY) == ""
    assert "sent again" in check.doubt(recorded, KEY)


def test_a_will_may_come_after_what_was_said_later_but_not_in_the_next_connection() -> None:
    check = SignatureCheck()
    sign = signer()
    will, online = sign(SAID), sign(SAID)
    assert [check.doubt(one, KEY) for one in (online, will)] == ["", ""]
    next_will, next_online = sign(SAID), sign(SAID)
    assert check.doubt(next_online, KEY) == ""
    assert "sent again" in check.doubt(will, KEY)
    assert check.doubt(next_will, KEY) == ""


def test_topics_have_counters_of_their_own() -> None:
    check = SignatureCheck()
    sign = signer()
    early = sign(replace(SAID, topic="macta/v1/hall/fred/factsheet"))
    assert check.doubt(sign(SAID), KEY) == ""
    assert check.doubt(early, KEY) == "", "it is retained and comes when the service subscribes"


def test_a_restarted_robot_is_believed_though_its_clock_stood_still() -> None:
    check = SignatureCheck()
    assert check.doubt(signer(100)(SAID), KEY) == ""
    assert check.doubt(signer(101)(SAID), KEY) == ""


def test_what_was_accepted_before_a_restart_is_refused_after_it_and_a_new_key_begins_anew() -> None:
    check = SignatureCheck()
    sign = signer()
    recorded, later = sign(SAID), sign(SAID)
    assert [check.doubt(one, KEY) for one in (recorded, later)] == ["", ""]
    restarted = SignatureCheck(check.accepted)
    assert "sent again" in restarted.doubt(recorded, KEY)
    assert restarted.doubt(sign(SAID), KEY) == ""
    renewed = Signer("another", epoch_ns=lambda: 1)
    assert restarted.doubt(renewed(SAID), "another") == ""


def test_a_signature_needs_nothing_but_hmac_sha256() -> None:
    """The example of docs/security.md, computed by `openssl dgst -sha256 -hmac a-key-of-fred`."""
    said = replace(SAID, counter="7")
    assert signature_of(KEY, said) == "d3bca85a51d0ae85434ea274aeb37c84af051958bccfe5fd802e57647debea7d"
