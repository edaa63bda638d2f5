"""Clocks for `PlanningRequest` that do not measure time: one that the test steps, one that counts its readings."""


class SteppedClock:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


class TickingClock:
    """Each reading is a millisecond after the one before it."""

    def __init__(self) -> None:
        self.readings = 0

    def __call__(self) -> float:
        self.readings += 1
        return self.readings / 1000
