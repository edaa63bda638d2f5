"""Addresses of databases are read as SQLAlchemy reads them."""

import pytest
from sqlalchemy import make_url

from app.database_url import DatabaseUrl


@pytest.mark.parametrize(
    "url",
    [
        "postgresql://macta:open-sesame@database.example:5432/macta",
        "postgresql+psycopg://macta@database.example/macta",
        "postgresql://macta:a%2Fb%40c%25@[::1]:5433/my%20record",
        "postgresql://macta:with/slash?and#more@127.0.0.1/macta",
        "postgresql://:word@/macta",
        "postgresql:///macta?host=/var/run/postgresql&user=macta",
        "postgresql://macta@/macta?host=one:5432&host=two:5433",
        "postgresql://macta@/macta?host=one,two&port=5432,5433",
        "postgresql://macta@database.example/macta?sslmode=require&application_name=a%40b",
        "postgresql://database.example",
    ],
)
def test_a_server_is_reached_with_the_parameters_that_sqlalchemy_would_give(url: str) -> None:
    parsed = make_url(url)
    _, theirs = parsed.get_dialect()().create_connect_args(parsed)
    theirs.pop("context", None)
    assert DatabaseUrl.of(url).server_parameters() == {name: str(value) for name, value in theirs.items()}


@pytest.mark.parametrize(
    "url", ["sqlite:////folder/file", "sqlite:///below/file", "sqlite+pysqlite:///file%20name?timeout=3"]
)
def test_a_file_is_found_where_sqlalchemy_finds_it(url: str) -> None:
    read = DatabaseUrl.of(url)
    assert (read.is_shared, read.database) == (False, make_url(url).database)


@pytest.mark.parametrize(
    ("url", "named"),
    [
        ("macta:open-sesame", "not of the form"),
        ("mysql://macta:open-sesame@host/macta", "mysql is not supported"),
        ("postgresql+asyncpg://macta:open-sesame@host/macta", r"postgresql\+asyncpg is not supported"),
        ("postgresql://macta:open-sesame@host:port/macta", "the port is no number"),
        ("sqlite://", "no database file"),
        ("sqlite:///:memory:", "no database file"),
    ],
)
def test_what_cannot_be_used_is_refused_without_its_password(url: str, named: str) -> None:
    with pytest.raises(ValueError, match=named) as refused:
        DatabaseUrl.of(url)
    assert "open-sesame" not in str(refused.value)
