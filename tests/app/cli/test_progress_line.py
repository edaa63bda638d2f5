"""Planning seen from a terminal."""

import io
import signal

import pytest
from rich.console import Console

from app.cli.progress_line import ProgressLine
from planner import Progress


def live(is_shown: bool = False) -> ProgressLine:
    return ProgressLine(Console(file=io.StringIO(), force_terminal=True, width=100), is_shown=is_shown)


def test_the_line_says_how_good_the_plan_is_and_could_be() -> None:
    line = live().line
    assert line(Progress(engine="lpg", elapsed_s=0.44)) == "lpg, 0.4 s: no plan yet"
    found = Progress(engine="macta", elapsed_s=3.2, makespan_s=104.4, lower_bound_s=98.0)
    assert line(found) == "macta, 3.2 s: plan of 104 s, none is shorter than 98 s"


def test_one_interruption_asks_for_the_best_so_far_and_the_next_gives_up() -> None:
    before = signal.getsignal(signal.SIGINT)
    with live() as planning:
        assert not planning.should_stop()
        signal.raise_signal(signal.SIGINT)
        assert planning.should_stop()
        assert "Ctrl-C again" in planning.line(Progress(engine="macta", elapsed_s=1))
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before


def test_the_line_is_drawn_only_where_it_is_to_be_shown() -> None:
    for is_shown in (True, False):
        file = io.StringIO()
        with ProgressLine(Console(file=file, force_terminal=True, width=100), is_shown=is_shown) as planning:
            planning.progress(Progress(engine="macta", elapsed_s=1, makespan_s=50))
        assert ("plan" in file.getvalue()) == is_shown
