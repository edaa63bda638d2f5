"""Blocks on a table, to be stacked otherwise: one arm, or two if actions have durations."""

from itertools import pairwise
from random import Random

from unified_planning.model import Problem

from benchmarks.domains.model import Form, Model, numbered


def problem(size: int, seed: int, form: Form) -> Problem:
    """:param size: blocks."""
    random = Random(f"blocksworld {size} {seed}")
    model = Model("blocksworld", form)
    model.kinds("block", "arm")
    model.predicates(on="block block", on_table="block", clear="block", holding="arm block", idle="arm")
    arm = {"arm": "arm", "block": "block"}
    pair = {**arm, "below": "block"}
    model.action(
        "take_up",
        arm,
        needs=["idle arm", "on_table block", "clear block"],
        deletes=["idle arm", "on_table block", "clear block"],
        adds=["holding arm block"],
        lasts=1,
    )
    model.action(
        "put_down",
        arm,
        needs=["holding arm block"],
        deletes=["holding arm block"],
        adds=["idle arm", "on_table block", "clear block"],
        lasts=1,
    )
    model.action(
        "unstack",
        pair,
        needs=["idle arm", "on block below", "clear block"],
        deletes=["idle arm", "on block below", "clear block"],
        adds=["holding arm block", "clear below"],
        lasts=2,
    )
    model.action(
        "stack",
        pair,
        needs=["holding arm block", "clear below"],
        deletes=["holding arm block", "clear below"],
        adds=["idle arm", "on block below", "clear block"],
        lasts=2,
    )
    blocks = model.objects("block", numbered("block", size))
    arms = model.objects("arm", numbered("arm", 2 if form is Form.TEMPORAL else 1))
    model.holds(*(f"idle {one}" for one in arms))
    for pile in _piles(blocks, random):
        model.holds(f"on_table {pile[0]}", f"clear {pile[-1]}")
        model.holds(*(f"on {upper} {lower}" for lower, upper in pairwise(pile)))
    wanted = [pair for pile in _piles(blocks, random) for pair in pairwise(pile)]
    model.wants(*(f"on {upper} {lower}" for lower, upper in wanted))
    return model.finished()


def _piles(blocks: list[str], random: Random) -> list[list[str]]:
    """The blocks in random order, cut into piles of about four; the first has at least two."""
    order = random.sample(blocks, len(blocks))
    piles = [order[:2]]
    for block in order[2:]:
        if random.random() < 0.25:
            piles.append([])
        piles[-1].append(block)
    return piles
