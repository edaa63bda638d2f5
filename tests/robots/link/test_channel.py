"""The pipe between two processes."""

import multiprocessing
from threading import Thread

from robots.link import PipeLink
from robots.link.channel import MAX_BATCH
from robots.wire import Message, Performative, Receipt


def receipt() -> Message:
    return Message(
        performative=Performative.CONFIRM, sender="service", receiver="fred", sent_at_s=0, body=Receipt()
    )


def test_of_a_sender_that_never_pauses_only_so_much_is_read_in_one_go() -> None:
    one, other = multiprocessing.Pipe()
    near, far = PipeLink(one), PipeLink(other)
    message, count = receipt(), 2 * MAX_BATCH + 1
    sender = Thread(target=lambda: [near.send(message) for _ in range(count)])
    sender.start()
    read: list[int] = []
    while sum(read) < count:
        read.append(len(far.receive(10.0)))
    sender.join()
    near.close()
    far.close()
    assert max(read) <= MAX_BATCH
