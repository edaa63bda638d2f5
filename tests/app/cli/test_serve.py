"""The socket that the service answers on."""

import socket

from app.cli.serve import listen
from app.settings import Settings


def test_the_parts_of_an_answer_are_sent_without_waiting_for_receipts() -> None:
    with listen(Settings(port=0)) as listener:
        listener.listen()
        with socket.create_connection(listener.getsockname()):
            served, _ = listener.accept()
            with served:
                assert served.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
