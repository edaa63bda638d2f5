"""Certificates of robots that the folder's own authority issues."""

from pathlib import Path

import pytest

from app.cli.certificates import Authority


def test_a_robot_gets_one_certificate_unless_it_is_renewed(tmp_path: Path) -> None:
    authority = Authority(tmp_path / "broker")
    made = authority.issue("yard_1", days=1)
    assert made is not None
    before = made.certificate.read_text()
    assert authority.issue("yard_1", days=1) is None
    assert made.certificate.read_text() == before
    assert authority.issue("yard_1", days=1, renew=True) == made
    assert made.certificate.read_text() != before


@pytest.mark.parametrize("lost", ["certificate", "key"])
def test_a_robot_of_which_one_file_is_lost_gets_both_anew(tmp_path: Path, lost: str) -> None:
    authority = Authority(tmp_path / "broker")
    made = authority.issue("yard_1", days=1)
    assert made is not None
    getattr(made, lost).unlink()
    assert authority.issue("yard_1", days=1) == made
    assert made.certificate.exists()
    assert made.key.exists()
