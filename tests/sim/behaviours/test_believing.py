"""Beliefs in the simulation: what whiskers alone tell of, what walls are not, and where it is narrow."""

from dataclasses import replace

import pytest

from benchmarks.trial import Trial, packet, room
from robots.repertoire import Repertoire, load_repertoire

WATCH = """
tag: STOP
about: Stands for some seconds and tells what it believes.
basic: true
retries: null
patterns:
  - {name: stand, dof: translate, level: task, stimulus: {sense: always},
     r: {form: constant, value: 0}, u: {form: constant, value: 1}}
events:
  believed: [{sense: believed, object: thing_1}]
  close: [{sense: close, object: thing_1, m: 1.2}]
after: [{sense: elapsed, s: 3}]
"""
POST = (4.0, 2.9, 4.2, 3.1)


def telling(tag: str, event: str, condition: dict[str, object]) -> Repertoire:
    """The shipped repertoire with one more event in a packet."""
    shipped = load_repertoire()
    spec = shipped.specs[tag]
    more = spec.model_copy(update={"events": {**spec.events, event: (condition,)}})
    return replace(shipped, specs={**shipped.specs, tag: more})


@pytest.mark.parametrize("seed", range(3))
def test_a_post_without_a_name_is_believed_in(seed: int) -> None:
    watch = load_repertoire([("watch", WATCH)])
    near = Trial(room(boxes=[POST]), packet("STOP"), seed=seed, repertoire=watch).run()
    bare = Trial(room(), packet("STOP"), seed=seed, repertoire=watch).run()
    assert sorted(near.events) == ["believed", "close"]
    assert bare.events == []


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("tag", ["FOLLOW_LEFT_OBSTACLE", "FOLLOW_RIGHT_OBSTACLE"])
def test_walls_are_taken_for_no_thing(tag: str, seed: int) -> None:
    watch = telling(tag, "believed", {"sense": "believed", "object": "thing_1"})
    trial = Trial(
        room(size=(5, 5), start=(2.5, 1, 0)), packet(tag, max_distance_m=10), seed=seed, repertoire=watch
    )
    assert "believed" not in trial.run(limit_s=90).events


@pytest.mark.parametrize("seed", range(3))
def test_a_passage_is_narrow_between_boxes_and_nowhere_else(seed: int) -> None:
    watch = telling("STEP", "narrow_passage", {"sense": "narrow_passage"})
    boxes = [(2.5, 1.0, 3.5, 2.55), (2.5, 3.45, 3.5, 5.0)]
    trial = Trial(
        room(start=(1, 3, 0), boxes=boxes), packet("STEP", distance_m=4), seed=seed, repertoire=watch
    )
    entered: list[float] = []

    def note() -> None:
        if "narrow_passage" in trial.events and not entered:
            entered.append(trial.pose.x_m)

    trial.run(each=note)
    assert trial.events == ["narrow_passage", "goal"]
    assert 1.7 < entered[0] < 2.9
