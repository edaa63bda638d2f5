"""The socket that the service answers on."""

import socket
from pathlib import Path

from typer.testing import CliRunner

from app.cli.main import app
from app.cli.serve import listen
from app.settings import Settings


def test_the_parts_of_an_answer_are_sent_without_waiting_for_receipts() -> None:
    with listen(Settings(port=0)) as listener:
        listener.listen()
        with socket.create_connection(listener.getsockname()):
            served, _ = listener.accept()
            with served:
                assert served.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_a_port_that_is_taken_is_said_in_a_line_before_anything_begins(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        done = CliRunner().invoke(app, ["serve", "--port", str(port), "--data", str(tmp_path / "data")])
    assert done.exit_code != 0
    assert f"cannot listen on 127.0.0.1:{port}: Address already in use; choose another --port" in done.stderr
    assert not list((tmp_path / "data").iterdir())
