"""What engines write of their schedules."""

from pathlib import Path

from planner.engines.temporal.best_plan import Step
from planner.engines.temporal.plan_files import PlanFiles, plan_file, steps_of, text_of

LPG = """
; Version LPG-td-1.4
; Seed 1
; MakeSpan 1008.00

0.0003:   (A_NAVIGATE O_STORE_2 O_HOME_STORE_2 O_BAY_10 O_AISLE_2) [82.0000])
82.0005:   (A_DOCK O_SAMPLE_1 O_STORE_1 O_BAY_1) [25.0000])


"""
STEPS = (
    Step(
        start=0.0003,
        duration=82.0,
        operator="a_navigate",
        objects=("o_store_2", "o_home_store_2", "o_bay_10", "o_aisle_2"),
    ),
    Step(start=82.0005, duration=25.0, operator="a_dock", objects=("o_sample_1", "o_store_1", "o_bay_1")),
)


def test_a_plan_file_is_read_without_its_comments_in_small_letters() -> None:
    assert steps_of(LPG) == STEPS


def test_what_is_written_is_read_back() -> None:
    assert steps_of(text_of(STEPS)) == STEPS


class Taking:
    """Stands in for the best plan: keeps the schedules."""

    def __init__(self) -> None:
        self.schedules: list[tuple[Step, ...]] = []

    def take(self, schedule: tuple[Step, ...]) -> None:
        self.schedules.append(schedule)

    def is_enough(self) -> bool:
        return len(self.schedules) == 2


def test_plan_files_are_taken_once_each_and_only_when_whole(tmp_path: Path) -> None:
    taking = Taking()
    files = PlanFiles(tmp_path, taking)  # type: ignore[arg-type]
    assert not files.is_enough()
    half = text_of(STEPS[:1])[:-1]
    plan_file(tmp_path, 1).write_text(half)
    assert not files.is_enough()
    assert taking.schedules == []
    plan_file(tmp_path, 1).write_text(text_of(STEPS[:1]))
    assert not files.is_enough()
    plan_file(tmp_path, 2).write_text(half)
    files.take(is_over=True)
    assert files.is_enough()
    assert taking.schedules == [STEPS[:1], STEPS[:1]]
