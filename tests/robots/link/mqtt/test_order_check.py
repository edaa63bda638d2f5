"""Orders to a robot with a key: each taken once, over restarts, from services whose clocks differ a little."""

from dataclasses import dataclass, field, replace

import pytest

from robots.link.mqtt.order_check import MAX_KEPT, NS, RESERVED_S, WINDOW_S, OrderCheck
from robots.link.mqtt.session import Publication
from robots.link.mqtt.signature import OrderSigner, Signer, signature_of

KEY = "a-key-of-fred"
ORDER = Publication(topic="macta/v1/hall/fred/order", payload=b'{"at_s": 1}', run="run-1")


@dataclass
class Store:
    """Kept in memory; counts what is written."""

    text: str | None = None
    written: int = 0
    fault: OSError | None = field(default=None)

    def load(self) -> str | None:
        return self.text

    def save(self, text: str) -> None:
        if self.fault is not None:
            raise self.fault
        self.text = text
        self.written += 1


def order(at_s: float, key: str = KEY) -> Publication:
    return Signer(key, epoch_ns=lambda: round(at_s * NS))(ORDER)


def test_each_order_is_taken_once_in_any_order() -> None:
    check = OrderCheck(KEY)
    first, second, third = order(1000), order(1001), order(1002)
    assert [check.doubt(one) for one in (first, third, second)] == ["", "", ""]
    assert all("sent again" in check.doubt(one) for one in (first, second, third))


@pytest.mark.parametrize(
    "forged",
    [
        ORDER,
        order(1000, key="another"),
        replace(order(1000), payload=b'{"at_s": 2}'),
        replace(order(1000), topic="macta/v1/hall/fred/instantActions"),
        replace(order(1000), run="run-2"),
        replace(order(1000), counter="1001"),
    ],
)
def test_what_is_not_the_services_word_by_word_is_refused_and_uses_nothing_up(forged: Publication) -> None:
    store = Store()
    check = OrderCheck(KEY, store)
    assert check.doubt(forged)
    assert store.written == 0
    assert check.doubt(order(1000)) == ""


def test_services_whose_clocks_differ_less_than_the_window_may_order_one_robot() -> None:
    check = OrderCheck(KEY)
    for at_s in range(1000, 1100):
        assert check.doubt(order(at_s)) == ""
        assert check.doubt(order(at_s + 0.5 - WINDOW_S / 2)) == ""
    assert "sent again" in check.doubt(order(1099 - WINDOW_S))


@pytest.mark.parametrize("taken_s", [0.0, 0.5, 4.9, 5.0, 5.1, 59.0, 600.0])
def test_no_order_taken_before_a_restart_is_taken_after_it(taken_s: float) -> None:
    store = Store()
    check = OrderCheck(KEY, store)
    taken = [order(1000 + at_s) for at_s in (0.0, 0.2, taken_s / 2 + 0.1, taken_s + 0.3)]
    assert not any(check.doubt(one) for one in taken)
    restarted = OrderCheck(KEY, store)
    assert all("sent again" in restarted.doubt(one) for one in taken)
    assert restarted.doubt(order(1000 + taken_s + 0.4 + RESERVED_S)) == "", "the service repeats it later"


def test_writes_are_rare() -> None:
    store = Store()
    check = OrderCheck(KEY, store)
    assert not any(check.doubt(order(1000 + tick / 10)) for tick in range(600))
    assert store.written <= 60 / RESERVED_S


def test_another_key_begins_anew() -> None:
    store = Store()
    assert OrderCheck(KEY, store).doubt(order(9000)) == ""
    assert OrderCheck("another", store).doubt(order(1000, key="another")) == ""
    assert "another" not in (store.text or "")


def test_an_order_is_taken_though_the_disk_is_full() -> None:
    assert OrderCheck(KEY, Store(fault=OSError("no space left"))).doubt(order(1000)) == ""


@pytest.mark.parametrize("text", ["", "[]", "{}", "nonsense", "1"])
def test_a_damaged_record_is_an_error(text: str) -> None:
    with pytest.raises(ValueError, match="no record of counters"):
        OrderCheck(KEY, Store(text))


def test_what_is_kept_of_a_window_is_bounded_and_forgets_nothing_taken() -> None:
    check = OrderCheck(KEY)
    taken = [replace(ORDER, counter=str(counter)) for counter in range(1, MAX_KEPT + 11)]
    taken = [replace(one, signature=signature_of(KEY, one)) for one in taken]
    assert not any(check.doubt(one) for one in taken)
    assert all(check.doubt(one) for one in (*taken[:20], *taken[-20:]))


def test_orders_to_robots_without_a_key_are_not_signed_and_a_new_key_is_used_at_once() -> None:
    keys = {"fred": KEY}
    signer = OrderSigner(lambda: keys, epoch_ns=lambda: 7)
    assert signer.sign("ginger", ORDER) == ORDER
    one, other = signer.sign("fred", ORDER), signer.sign("fred", ORDER)
    assert int(other.counter) > int(one.counter)
    keys["fred"] = "another"
    renewed = signer.sign("fred", ORDER)
    assert renewed.signature == signature_of("another", renewed)
