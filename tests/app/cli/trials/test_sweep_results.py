"""What many seeds come to."""

import pytest

from app.cli.trials.sweep_results import Outcome, SeedResult, SweepSummary, wilson


def row(
    seed: int, outcome: Outcome, packet: str | None = None, reason: str = "", took_s: float = 40.0
) -> SeedResult:
    there = None if outcome is Outcome.UNPLANNED else took_s
    return SeedResult(
        seed=seed,
        goal="move sample_1 to bay_7",
        outcome=outcome,
        took_s=there,
        estimate_s=None if there is None else 50.0,
        packet=packet,
        reason=reason,
    )


ROWS = [
    row(0, Outcome.CAME_TRUE),
    row(1, Outcome.FAILED, "DOCK", "yard_1 at (2.1, 3.0): sample_1 not seen for 20 s", 300.0),
    row(2, Outcome.FAILED, "DOCK", "yard_1 at (2.4, -3.1): sample_1 not seen for 21 s", 310.0),
    row(3, Outcome.FAILED, "NAVIGATE", "no way"),
    row(4, Outcome.CAME_TRUE, took_s=60.0),
    row(5, Outcome.UNPLANNED, reason="unsolvable"),
]


def test_the_rate_is_of_missions_that_were_tried() -> None:
    tally = SweepSummary.of(ROWS)
    assert (tally.seeds, tally.tried, tally.came_true, tally.rate) == (6, 5, 2, 0.4)
    assert [(group.reason, group.seeds) for group in tally.unplanned] == [("unsolvable", (5,))]


def test_failures_are_grouped_by_packet_and_words_whatever_their_numbers() -> None:
    dock, navigate = SweepSummary.of(ROWS).failures
    assert (dock.packet, dock.seeds) == ("DOCK", (1, 2))
    assert dock.reason == ROWS[1].reason
    assert (navigate.packet, navigate.seeds) == ("NAVIGATE", (3,))


def test_times_are_of_missions_that_came_true() -> None:
    tally = SweepSummary.of(ROWS)
    assert tally.took_s is not None
    assert (tally.took_s.median, tally.took_s.least, tally.took_s.most) == (50.0, 40.0, 60.0)
    assert tally.ratio is not None
    assert tally.ratio.most == 1.2


def test_without_a_plan_there_is_no_rate() -> None:
    tally = SweepSummary.of(ROWS[-1:])
    assert (tally.tried, tally.rate, tally.interval, tally.took_s) == (0, None, None, None)


@pytest.mark.parametrize(
    ("good", "of", "low", "high"), [(20, 20, 0.839, 1.0), (0, 10, 0.0, 0.278), (81, 263, 0.255, 0.366)]
)
def test_the_interval_is_wilsons(good: int, of: int, low: float, high: float) -> None:
    """81 of 263 is Newcombe's example (1998, table I)."""
    assert wilson(good, of) == pytest.approx((low, high), abs=5e-4)
