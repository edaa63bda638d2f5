"""Random goals: among those that are possible in a world, and sentences of any verb."""

import random

from app.domain.errors import Invalid
from app.domain.goal_language.check import check_goals
from app.domain.goal_language.reachability import free_for
from app.domain.goal_language.verbs import Kind, Role, Verbs
from app.domain.world_model import Facts
from planner import KnowledgeBase
from robots.wire import SymbolicFact
from robots.world import WorldFile

PASSING = frozenset({"interchange", "home"})
"""Kinds of places where no sample is left, because it would be in the way."""
DRAWS = 200


def drawn_goals(
    world: WorldFile, facts: Facts, count: int, seed: int, knowledge_base: KnowledgeBase
) -> tuple[SymbolicFact, ...]:
    """Goals for `count` different samples, each to a location with room for it that it can be carried to.

    :raises Invalid: if no such goals are found.
    """
    chance = random.Random(seed)
    places = {
        sample.name: [p for p in free_for(sample.name, world, facts) if world.location(p).kind not in PASSING]
        for sample in world.samples
    }
    movable = [sample for sample in places if places[sample]]
    for _ in range(DRAWS if len(movable) >= count else 0):
        samples = chance.sample(movable, count)
        goals = tuple(
            SymbolicFact(predicate="in", args=(sample, chance.choice(places[sample]))) for sample in samples
        )
        if not check_goals(goals, world, facts, knowledge_base):
            return goals
    raise Invalid(
        f"found no {count} goals at once that {world.name} can take: it has {len(movable)} samples that can be carried "
        "to a free place; ask for fewer goals, or state them"
    )


def drawn_sentence(world: WorldFile, verbs: Verbs, chance: random.Random) -> str:
    """A sentence of one of the verbs about things of the world; it may be impossible there.

    :raises Invalid: if the world lacks what each of the verbs is about.
    """
    things = {
        Kind.SAMPLE: [sample.name for sample in world.samples],
        Kind.ROBOT: [robot.name for robot in world.robots],
        Kind.PLACE: [place.name for place in world.locations if place.kind not in PASSING],
    }
    fitting = [
        word for word in verbs.words if all(things[slot.kind] for slot in verbs.by_word[word].slots.values())
    ]
    if not fitting:
        raise Invalid(f"no verb of the packs is about what {world.name} has: {', '.join(verbs.words)}")
    word = chance.choice(fitting)
    said = {slot.role: chance.choice(things[slot.kind]) for slot in verbs.by_word[word].slots.values()}
    parts = [word, said[Role.OBJECT]]
    parts += ["and", said[Role.PARTNER]] if Role.PARTNER in said else []
    parts += ["to", said[Role.TARGET]] if Role.TARGET in said else []
    return " ".join(parts)
