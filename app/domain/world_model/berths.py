"""Locations with several berths, and the berths that statements about such a location refer to."""

from collections.abc import Iterable, Iterator, Sequence

from app.domain.errors import Conflict, Invalid
from app.domain.world_model.beliefs import CLEAR, IN, OBJECT_POSITION, REACHES, VACANT, Facts, place_of
from robots.world import WorldFile

Statement = tuple[str, Sequence[str], bool]
"""Predicate and arguments in rel/ref form, and whether it holds."""
ALL_BERTHS = frozenset({VACANT, CLEAR, REACHES})
"""Predicates whose statements about a location hold for every one of its berths."""


def berths_of(name: str, world: WorldFile) -> tuple[str, ...]:
    """The names of a location's berths; empty if it has only one, or is no location."""
    row = world.places_by_location.get(name, ())
    return tuple(place.name for place in row) if len(row) > 1 else ()


def interchanges(world: WorldFile) -> tuple[str, ...]:
    """The names of the locations at which samples pass from one area to another."""
    return tuple(name for name in world.places_by_location if world.location(name).kind == "interchange")


def resolve_statements(statements: Iterable[Statement], world: WorldFile, facts: Facts) -> list[Statement]:
    """The statements with berths instead of locations that have several.

    A sample stated to lie in such a location gets its believed berth if that is one of the location's, else the first
    free one. A sample stated not to lie there lies in none of the berths.

    :raises Conflict: if no berth is free.
    :raises Invalid: if a statement must name a berth and does not.
    """
    said = list(statements)
    moved = {args[0] for predicate, args, _ in said if predicate == IN and args}
    taken = {f.args[2] for f in facts if f.predicate == OBJECT_POSITION and f.args[0] not in moved}
    taken |= {args[1] for predicate, args, holds in said if predicate == IN and holds and len(args) > 1}
    found: list[Statement] = []
    for predicate, args, holds in said:
        name = next((arg for arg in args if berths_of(arg, world)), None)
        if name is None:
            found.append((predicate, args, holds))
            continue
        for berth in _berths_of_statement(predicate, args, holds, name, world, facts, taken):
            found.append((predicate, tuple(berth if arg == name else arg for arg in args), holds))
            taken.add(berth)
    return found


def _berths_of_statement(
    predicate: str,
    args: Sequence[str],
    holds: bool,
    name: str,
    world: WorldFile,
    facts: Facts,
    taken: set[str],
) -> Iterator[str]:
    berths = berths_of(name, world)
    if predicate in ALL_BERTHS or (predicate == IN and not holds):
        yield from berths
        return
    if predicate != IN:
        raise Invalid(f"{name} has {len(berths)} berths; name one", code="berth-needed", choices=berths)
    lies = place_of(args[0], facts)
    free = [berth for berth in sorted(berths, key=lambda berth: berth != lies) if berth not in taken]
    if not free:
        raise Conflict(
            f"{name} has no room for {args[0]}: none of its {len(berths)} berths is free",
            code="place-occupied",
            choices=berths,
        )
    yield free[0]
