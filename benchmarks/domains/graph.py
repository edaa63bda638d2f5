"""Random connected graphs."""

from collections.abc import Iterator, Sequence
from random import Random


def connected(nodes: Sequence[str], more: int, random: Random) -> Iterator[tuple[str, str]]:
    """The edges of a random tree over the nodes, and up to so many more."""
    made: set[frozenset[str]] = set()
    for number in range(1, len(nodes)):
        pair = nodes[number], nodes[random.randrange(number)]
        made.add(frozenset(pair))
        yield pair
    for _ in range(more):
        one, other = random.sample(nodes, 2)
        if frozenset((one, other)) not in made:
            made.add(frozenset((one, other)))
            yield one, other
