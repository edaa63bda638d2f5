"""What an operator is told of the packet under way who looks into it: its conditions, as the robot perceives them."""

from collections.abc import Iterator

from robots.conditions import Condition
from robots.errors import SensorOff
from robots.executive.packet_run import PacketRun
from robots.perception.percepts import Percepts
from robots.wire import TracedCondition


def conditions_of(run: PacketRun | None) -> tuple[TracedCondition, ...]:
    """What starts, sustains and ends the packet, each as it was at its last tick."""
    if run is None or run.perceived is None:
        return ()
    content = run.content
    groups = (("before", content.before), ("maintain", content.maintain), ("after", content.after))
    return tuple(_judged(groups, run.perceived))


def _judged(
    groups: tuple[tuple[str, tuple[Condition, ...]], ...], percepts: Percepts
) -> Iterator[TracedCondition]:
    for when, conditions in groups:
        for condition in conditions:
            try:
                verdict = condition.check(percepts)
            except SensorOff:  # of a pre-condition, once the packet runs
                words = f"does not sense {', '.join(sorted(condition.needs))} now"
                yield TracedCondition(when=when, words=words)
            else:
                yield TracedCondition(when=when, words=verdict.words, holds=verdict.holds)
