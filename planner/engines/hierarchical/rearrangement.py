"""Things that lie where others are to go, ordered by the rooms that they leave and take up.

Each task's fragments are found as if the rooms of all things that move were free. A task is carried out once the rooms
that it takes up are; where tasks wait for each other in a circle, one of them puts its thing aside in a free room and
goes on later. That order is the first schedule; scheduling may improve it by any other.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field

from planner.engines.hierarchical.blocking import FindFragments
from planner.engines.hierarchical.fragments.fragment import Fragment
from planner.engines.hierarchical.legs.goal_groups import Goals, Group, Groups
from planner.engines.hierarchical.legs.leg import ClassifiedProblem
from planner.engines.hierarchical.legs.setups import ReturnHome
from planner.engines.hierarchical.rooms import Rooms
from planner.engines.hierarchical.scheduling_problem import Move
from planner.fact import Fact
from planner.knowledge import GroundAction
from planner.plan_nets.progression import progressed

NEAREST = 12
"""Maximum number of free places to which fragments are bound for one thing."""
PLACES_ASIDE = 6
"""Maximum number of places in which one task may put its things aside."""
MAX_ASIDES = 48
"""Maximum number of fragments that put something aside, of all tasks together."""
KNOWN_ONLY = 0
SMALLEST_WORLD_ONLY = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Rearranged:
    """Tasks with their fragments, and the moves of an order in which they can be carried out.

    A move's task is the number of a key of `ways`.
    """

    ways: Mapping[Group, Sequence[Fragment]]
    moves: Sequence[Move]


@dataclass(slots=True, kw_only=True)
class _Waiting:
    """A task not carried out yet: its fragments from where its things are now."""

    group: Group
    fragments: Sequence[Fragment]
    first: int = 0


@dataclass(slots=True, kw_only=True)
class _State:
    """Who takes up which room in the course of the moves."""

    holder: dict[Fact, Group]
    moves: list[Move] = field(default_factory=list)

    def put(self, group: Group, rooms: Iterable[Fact]) -> None:
        """The group's things take up these rooms and leave those before."""
        self.holder = {room: other for room, other in self.holder.items() if other != group}
        self.holder |= dict.fromkeys(rooms, group)

    def in_the_way(self, group: Group, rooms: Iterable[Fact]) -> list[Group]:
        """Other groups that hold some of the rooms, in an order that does not depend on hashes."""
        held = (self.holder[room] for room in sorted(rooms) if room in self.holder)
        return [other for other in dict.fromkeys(held) if other != group]


class Rearrangement:
    """Orders the tasks of one problem by the rooms of their things."""

    def __init__(self, classified: ClassifiedProblem, groups: Groups, find: FindFragments) -> None:
        self._problem = classified.problem
        self._groups = groups
        self._find = find
        self._rooms = rooms = Rooms(classified, groups)
        self._return_home = ReturnHome(classified)
        everything = (*groups.wanted, *groups.idle)
        self._holder = {room: group for group in everything for room in rooms.held(group)}
        self._open = [group for group in groups.wanted if groups.is_open(group, self._problem.facts)]
        needed = {room for group in self._open for room in rooms.wanted(group)}
        self._evicted = [group for group in groups.idle if not needed.isdisjoint(rooms.held(group))]
        self._moving = (*self._open, *self._evicted)
        released = {room for group in self._moving for room in rooms.held(group)}
        self._facts = self._problem.facts | released
        self._wanted = needed
        self._passed: set[Fact] = set()
        self._asides: dict[Group, list[tuple[Fragment, int]]] = defaultdict(list)

    def found(self) -> Rearranged | None:
        """None if nothing lies in another thing's room, or if there is no such order."""
        rooms = self._rooms
        state = _State(holder=dict(self._holder))
        if not any(state.in_the_way(group, rooms.wanted(group)) for group in self._open):
            return None
        straight = {group: self._straight(group) for group in self._open}
        if not all(straight.values()):
            return None
        self._passed = {
            room
            for group, fragments in straight.items()
            for room in self._taken(group, fragments[0].actions) - rooms.wanted(group)
        }
        waiting = [_Waiting(group=group, fragments=straight[group]) for group in self._open]
        waiting.sort(key=lambda one: self._groups.is_final_configuration(one.group))
        evicted = list(self._evicted)
        while waiting:
            if not self._carried_out(state, waiting) and not self._put_aside(state, waiting, evicted):
                return None
        self._vary(straight)
        return Rearranged(
            ways={
                group: (*straight.get(group, ()), *(fragment for fragment, _ in self._asides[group]))
                for group in self._moving
            },
            moves=state.moves,
        )

    def _straight(self, group: Group) -> list[Fragment]:
        others = [other for other in (*self._groups.wanted, *self._groups.idle) if other != group]
        found = self._find(self._facts, group.goals)
        return [fragment for fragment in found if not self._groups.moved(fragment.actions, others)]

    def _taken(self, group: Group, actions: Iterable[GroundAction]) -> frozenset[Fact]:
        """The rooms that a group's things take up in the course of the actions."""
        return self._rooms.of_all(
            fact for action in actions for fact in action.effects if not group.things.isdisjoint(fact.args)
        )

    def _left_in(self, group: Group, actions: Sequence[GroundAction]) -> frozenset[Fact]:
        """The rooms in which the actions leave a group's things."""
        after = progressed(self._groups.place(group), actions)
        return self._rooms.of_all(fact for fact in after if not group.things.isdisjoint(fact.args))

    def _carried_out(self, state: _State, waiting: list[_Waiting]) -> bool:
        """Carry out the first task whose rooms are free; False if none is."""
        for one in waiting:
            for fragment in one.fragments:
                taken = self._taken(one.group, fragment.actions[one.first :])
                if not state.in_the_way(one.group, taken):
                    state.put(one.group, self._rooms.wanted(one.group))
                    actions = fragment.actions
                    state.moves.append(self._move(one.group, actions, one.first, len(actions)))
                    waiting.remove(one)
                    return True
        return False

    def _move(self, group: Group, actions: tuple[GroundAction, ...], first: int, last: int) -> Move:
        return Move(task=self._moving.index(group), actions=actions, first=first, last=last)

    def _put_aside(self, state: _State, waiting: Sequence[_Waiting], evicted: list[Group]) -> bool:
        """Put aside what another task waits for: things without a goal, else those of a task in a circle."""
        for group in self._in_circle(state, waiting, evicted):
            for fragment, last in self._aside(group, self._free(state, waiting)):
                actions = fragment.actions
                taken = self._taken(group, actions[:last])
                if state.in_the_way(group, taken):
                    continue
                if (fragment, last) not in self._asides[group]:
                    self._asides[group].append((fragment, last))
                state.moves.append(self._move(group, actions, 0, last))
                state.put(group, self._left_in(group, actions[:last]))
                for one in waiting:
                    if one.group == group:
                        one.fragments = [fragment]
                        one.first = last
                if group in evicted:
                    evicted.remove(group)
                return True
        return False

    def _in_circle(self, state: _State, waiting: Sequence[_Waiting], evicted: Sequence[Group]) -> list[Group]:
        """The groups that tasks wait for, from the first one on, each followed to the next; those of a circle first.

        A fragment that puts something aside begins where it is at first: only what has not moved yet can be put aside.
        """
        tasks = {one.group: one for one in waiting}
        found: dict[Group, None] = {}
        for one in waiting:
            chain: dict[Group, int] = {one.group: 0}
            here: _Waiting | None = one
            while here is not None:
                taken = self._taken(here.group, here.fragments[0].actions[here.first :])
                blocking = state.in_the_way(here.group, taken)
                after = next((other for other in blocking if other not in chain), None)
                if after is None:
                    circle = list(chain)[min((chain[other] for other in blocking), default=len(chain)) :]
                    found |= dict.fromkeys(circle)
                    break
                chain[after] = len(chain)
                here = tasks.get(after)
                if here is None:
                    found = {after: None, **found}
        return [group for group in found if group in evicted or (group in tasks and tasks[group].first == 0)]

    def _free(self, state: _State, waiting: Sequence[_Waiting]) -> Set[Fact]:
        """The rooms that are free and that no task needs that has not been carried out."""
        wanted = {room for one in waiting for room in self._rooms.wanted(one.group)}
        free = self._facts - state.holder.keys()
        return (free - wanted - self._passed) or (free - wanted) or free

    def _aside(self, group: Group, free: Set[Fact]) -> Iterator[tuple[Fragment, int]]:
        """Fragments that put a group's things aside in a free room, the nearest first, and go on to its goals; with the
        number of actions until then."""
        for aside in self._places(group, free):
            after = self._return_home.after(self._facts, aside.actions)
            on = self._on(after, group) if group.goals else aside
            if on is not None:
                actions = (*aside.actions, *on.actions) if group.goals else aside.actions
                yield Fragment(goals=group.goals, actions=actions), len(aside.actions)

    def _on(self, facts: frozenset[Fact], group: Group) -> Fragment | None:
        others = [other for other in (*self._groups.wanted, *self._groups.idle) if other != group]
        for levels in (KNOWN_ONLY, SMALLEST_WORLD_ONLY):
            for fragment in self._find(facts, group.goals, levels=levels):
                if not self._groups.moved(fragment.actions, others):
                    return fragment
        return None

    def _places(self, group: Group, free: Set[Fact]) -> list[Fragment]:
        """How the things get to places like the present one with a free room; the nearest first."""
        others = [other for other in (*self._groups.wanted, *self._groups.idle) if other != group]
        near = sorted(self._alike(group, free))[:NEAREST]
        found = []
        for levels in (KNOWN_ONLY, SMALLEST_WORLD_ONLY):
            for _, place in near:
                ways = self._find(self._facts, place, levels=levels)
                way = next((way for way in ways if not self._groups.moved(way.actions, others)), None)
                if way is not None:
                    found.append((way.duration_s, place, way))
            if found:
                break
        found.sort(key=lambda item: item[:2])
        return [way for _, _, way in found]

    def _alike(self, group: Group, free: Set[Fact]) -> Iterator[tuple[float, Goals]]:
        """The group's place with another object of the same type whose room is free, and how far that is."""
        objects = self._problem.objects
        present = self._groups.place(group)
        named = sorted({arg for fact in present for arg in fact.args if arg in objects} - group.things)
        for old in named:
            away = self._away(old)
            for new, kind in objects.items():
                if kind == objects[old] and new != old:
                    place = tuple(fact.renamed({old: new}) for fact in present)
                    rooms = self._rooms.of_all(place)
                    if rooms and rooms <= free:
                        yield away.get(new, 0.0), place

    def _away(self, place: str) -> Mapping[str, float]:
        """How far other objects are, by functions of two objects."""
        return {
            args[1]: value
            for (_, args), value in self._problem.functions.items()
            if len(args) == 2 and args[0] == place
        }

    def _vary(self, straight: Mapping[Group, Sequence[Fragment]]) -> None:
        """More places aside for the tasks that wait for each other."""
        waits = {
            group: [
                other
                for room in self._rooms.wanted(group)
                if (other := self._holder.get(room)) is not None and other != group
            ]
            for group in straight
        }
        circles = [group for group in straight if group in _followed(waits, group)]
        varied = [*circles, *(group for group in self._evicted if self._asides[group])]
        state = _State(holder=dict(self._holder))
        free = self._facts - state.holder.keys() - self._passed
        each = min(PLACES_ASIDE, MAX_ASIDES // max(1, len(varied)))
        for group in varied:
            allowed = free if group.goals else free - self._wanted
            for item in self._aside(group, allowed):
                if len(self._asides[group]) >= each:
                    break
                if item not in self._asides[group]:
                    self._asides[group].append(item)


def _followed(waits: Mapping[Group, Sequence[Group]], group: Group) -> set[Group]:
    """What the group waits for, and what that waits for, and so on."""
    found: set[Group] = set()
    fringe = list(waits.get(group, ()))
    while fringe:
        here = fringe.pop()
        if here not in found:
            found.add(here)
            fringe += waits.get(here, ())
    return found
