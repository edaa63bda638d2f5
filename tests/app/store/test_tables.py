"""What the tables declare beside their columns."""

from app.store import Base


def test_what_a_new_row_has_by_default_old_rows_got_when_the_column_was_added() -> None:
    columns = [column for table in Base.metadata.tables.values() for column in table.columns]
    both = [one for one in columns if one.default is not None and one.server_default is not None]
    assert both
    for column in both:
        by_code = column.default.arg([]) if column.default.is_callable else column.default.arg
        by_database = getattr(column.server_default.arg, "text", column.server_default.arg)
        assert str(by_database) == str(by_code).lower(), column
