"""Instances by family, size and seed: generated worlds, samples and goals drawn at random.

store, retrieve, mixed: each sample between a door of its own and a bay; four robots for up to 16 samples, in
proportion beyond, half in the yard and half in the store, one an aisle. two_ways: mixed, each aisle with two
interchanges. paper: four robots, two doors at which all the
samples lie (more at one door than a world file allows). blocked, swap, relocation: goals that interact, paper size.
full: samples in all bays, none of which may stay; nearly_full: in all but one. random: a world of any shape, samples
anywhere, goals for some of them, to places that may have to be cleared first. rearranged: half of the samples to other
bays, a third of them free.
"""

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from app.domain.world_model import initial_facts, initial_spots, planning_problem
from planner import Fact, KnowledgeBase, PlanningProblem
from robots.world import Sample as LyingSample
from robots.world import WorldFile, generate_world, store_shape


@dataclass(frozen=True, slots=True, kw_only=True)
class Instance:
    """A world, where its samples lie, and where they are to go. `stacked`: samples that share another's door."""

    family: str
    seed: int
    world: WorldFile
    targets: Mapping[str, str]
    stacked: Mapping[str, str]

    @property
    def samples(self) -> int:
        return len(self.targets)

    @property
    def robots(self) -> int:
        return len(self.world.robots)

    def problem(self, knowledge_base: KnowledgeBase) -> PlanningProblem:
        """As the service poses it, from the world's initial facts."""
        facts = initial_facts(self.world, knowledge_base)
        goals = [Fact("object_position", (sample, "in", place)) for sample, place in self.targets.items()]
        problem = planning_problem(self.world, facts, goals, spots=initial_spots(self.world))
        if not self.stacked:
            return problem
        more = {Fact("object_position", (sample, "in", place)) for sample, place in self.stacked.items()}
        return replace(
            problem,
            objects={**problem.objects, **dict.fromkeys(self.stacked, "object")},
            facts=problem.facts | more,
        )


def robots_for(samples: int) -> int:
    return max(4, samples // 4)


def _world(samples: int, doors: int, robots: int, bays: int | None = None, ways: int = 1) -> WorldFile:
    """A store with bays for all the samples, none of them in it yet. `ways`: interchanges of each aisle."""
    half = robots // 2
    bays = bays or max(6 * half, samples + samples // 2)
    shape = store_shape(
        samples=0,
        aisles=half,
        store_robots=half,
        yard_robots=half,
        doors=doors,
        bays=bays,
        interchanges=ways * half,
    )
    return generate_world(shape)


def _places(world: WorldFile, kind: str, chance: random.Random) -> list[str]:
    names = [place.name for place in world.locations if place.kind == kind]
    return chance.sample(names, len(names))


def _made(family: str, seed: int, world: WorldFile, ways: Sequence[tuple[str, str]]) -> Instance:
    """The instance in which sample_1, sample_2, … each go from one place to another."""
    lying = {f"sample_{number}": start for number, (start, _) in enumerate(ways, start=1)}
    first: dict[str, str] = {}
    for sample, start in lying.items():
        first.setdefault(start, sample)
    samples = tuple(LyingSample(name=sample, at=start) for start, sample in first.items())
    return Instance(
        family=family,
        seed=seed,
        world=WorldFile.model_validate({**world.model_dump(), "samples": [s.model_dump() for s in samples]}),
        targets={f"sample_{number}": end for number, (_, end) in enumerate(ways, start=1) if end},
        stacked={sample: start for sample, start in lying.items() if first[start] != sample},
    )


def _carried(
    family: str, stored: Callable[[int], int], interchanges: int = 1
) -> Callable[[int, int], Instance]:
    """The family of which `stored(samples)` samples go from doors to bays and the others from bays to doors."""

    def make(samples: int, seed: int) -> Instance:
        chance = random.Random(f"{family}/{samples}/{seed}")
        world = _world(samples, max(2, samples), robots_for(samples), ways=interchanges)
        doors = _places(world, "door", chance)
        bays = _places(world, "bay", chance)
        pairs = list(zip(doors, bays, strict=False))[:samples]
        ways = [pair if n < stored(samples) else (pair[1], pair[0]) for n, pair in enumerate(pairs)]
        return _made(family, seed, world, ways)

    return make


def _paper(samples: int, seed: int) -> Instance:
    chance = random.Random(f"paper/{samples}/{seed}")
    world = _world(samples, 2, 4)
    bays = _places(world, "bay", chance)
    return _made("paper", seed, world, [(f"door_{n % 2 + 1}", bays[n]) for n in range(samples)])


def _blocked(samples: int, seed: int) -> Instance:
    """Samples to bays that are occupied by samples without a goal."""
    chance = random.Random(f"blocked/{samples}/{seed}")
    world = _world(2 * samples, 2, 4)
    bays = _places(world, "bay", chance)
    starts = ["door_1", *bays[samples:]]
    return _made(
        "blocked",
        seed,
        world,
        [*zip(starts, bays[:samples], strict=False), *((b, "") for b in bays[:samples])],
    )


def _swap(samples: int, seed: int) -> Instance:
    """Pairs of samples that change places."""
    chance = random.Random(f"swap/{samples}/{seed}")
    bays = _places(world := _world(samples, 2, 4), "bay", chance)[:samples]
    return _made("swap", seed, world, [(bays[n], bays[n ^ 1]) for n in range(samples)])


def _relocation(samples: int, seed: int) -> Instance:
    """Each sample to the bay that the next one leaves, the last one to a free bay."""
    chance = random.Random(f"relocation/{samples}/{seed}")
    bays = _places(world := _world(samples, 2, 4), "bay", chance)[: samples + 1]
    return _made("relocation", seed, world, list(pairwise(bays)))


def _full(samples: int, seed: int) -> Instance:
    """As many bays as samples, each of which goes to the bay of another: only doors and interchanges are free."""
    chance = random.Random(f"full/{samples}/{seed}")
    bays = _places(world := _world(samples, 2, robots_for(samples), samples), "bay", chance)
    ends = list(bays)
    while any(one == other for one, other in zip(bays, ends, strict=True)):
        chance.shuffle(ends)
    return _made("full", seed, world, list(zip(bays, ends, strict=True)))


def _nearly_full(samples: int, seed: int) -> Instance:
    """One bay more than samples, each of which goes to another's bay or to the free one; two robots an aisle."""
    chance = random.Random(f"nearly_full/{samples}/{seed}")
    bays = _places(world := _world(samples, 2, 4, samples + 1), "bay", chance)
    lying, ends = bays[:samples], chance.sample(bays, samples)
    while any(one == other for one, other in zip(lying, ends, strict=True)):
        ends = chance.sample(bays, samples)
    return _made("nearly_full", seed, world, list(zip(lying, ends, strict=True)))


def _random(goals: int, seed: int) -> Instance:
    """A world of 1 to 3 aisles with samples in some of its doors and bays, half as many more as there are goals."""
    chance = random.Random(f"random/{goals}/{seed}")
    aisles = chance.randint(1, 3)
    shape = store_shape(
        samples=0,
        aisles=aisles,
        store_robots=aisles,
        yard_robots=chance.randint(1, 3),
        doors=chance.randint(2, 4),
        bays=max(4 * aisles, goals + chance.randint(2, 6)),
    )
    world = generate_world(shape)
    places = [*_places(world, "door", chance), *_places(world, "bay", chance)]
    chance.shuffle(places)
    lying = places[: goals + (goals + 1) // 2]
    ends = chance.sample(places, goals)
    while any(one == other for one, other in zip(lying, ends, strict=False)):
        ends = chance.sample(places, goals)
    return _made(
        "random", seed, world, [*zip(lying, ends, strict=False), *((at, "") for at in lying[goals:])]
    )


def _rearranged(samples: int, seed: int) -> Instance:
    """Samples in two thirds of the bays; half of them go to bays that are free or that others leave."""
    chance = random.Random(f"rearranged/{samples}/{seed}")
    bays = _places(world := _world(samples, 2, robots_for(samples)), "bay", chance)
    lying = bays[:samples]
    moving = set(chance.sample(lying, samples // 2))
    ends = chance.sample([bay for bay in bays if bay in moving or bay not in lying], len(moving))
    aims = {one: other for one, other in zip(sorted(moving), ends, strict=True) if one != other}
    return _made("rearranged", seed, world, [(bay, aims.get(bay, "")) for bay in lying])


FAMILIES: Mapping[str, Callable[[int, int], Instance]] = {
    "store": _carried("store", lambda samples: samples),
    "mixed": _carried("mixed", lambda samples: (samples + 1) // 2),
    "retrieve": _carried("retrieve", lambda samples: 0),
    "two_ways": _carried("two_ways", lambda samples: (samples + 1) // 2, interchanges=2),
    "paper": _paper,
    "blocked": _blocked,
    "swap": _swap,
    "relocation": _relocation,
    "full": _full,
    "nearly_full": _nearly_full,
    "random": _random,
    "rearranged": _rearranged,
}
"""Family → its instance by number of samples and seed."""
