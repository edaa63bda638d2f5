"""The benchmark of takeovers, which is also the proof that there is one."""

from app.workflows.leases import DEAD_AFTER_S, HEARTBEAT_S
from benchmarks.recovery import takeover_s
from tests.databases import ON_POSTGRESQL

PROMISED_S = 15.0


@ON_POSTGRESQL
def test_what_a_killed_process_left_undone_another_goes_on_with(database_url: str) -> None:
    assert takeover_s(database_url) > DEAD_AFTER_S - 2 * HEARTBEAT_S, "it was taken from a living process"


def test_the_silence_that_counts_as_death_leaves_time_for_the_takeover() -> None:
    assert DEAD_AFTER_S + 2 * HEARTBEAT_S < PROMISED_S
