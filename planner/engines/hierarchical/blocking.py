"""Tasks whose things block each other: what has to be put aside, and the fragments that do so.

A sample that lies at another's goal may be brought to its own goal first or be put down elsewhere for a while.
Fragments only offer the possibilities; scheduling decides which task makes way, where and when.
"""

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Protocol

from planner.engines.hierarchical.fragments.discovery import ALL_LEVELS
from planner.engines.hierarchical.fragments.fragment import Fragment
from planner.engines.hierarchical.legs.goal_groups import Goals, Group, Groups
from planner.engines.hierarchical.legs.leg import ClassifiedProblem
from planner.engines.hierarchical.legs.setups import ReturnHome
from planner.fact import Fact
from planner.knowledge import GroundAction
from planner.plan_nets.extraction import fault_of


class FindFragments(Protocol):
    """Finds fragments for goals."""

    def __call__(
        self, facts: frozenset[Fact], goals: Goals, *, levels: int = ALL_LEVELS
    ) -> Sequence[Fragment]:
        """The fragments that reach goals from facts, quickest first; none if none was found.

        :param levels: how wide a world is searched; 0: none, only fragments known from other goals are used.
        """


PlacesAside = Mapping[Group, Goals]
"""By group, the facts that hold once its things are put aside."""
WAYS_ASIDE = 2
"""Maximum number of fragments that put things in one place."""
WAYS_ON = 4
"""Maximum number of fragments from there to the goals."""
NO_ACTIONS = Fragment(goals=(), actions=())
MAX_DETOURS = 8
"""Maximum number of fragments of a task that pass a place aside."""
SMALLEST_WORLD_ONLY = 1
"""Search levels for fragments that put something aside: the smallest world only."""
PLACES = 40
"""If a type has more objects than this, only those where a fragment has put things are considered as places."""


class BlockingTasks:
    """Finds the fragments of tasks that make way for each other."""

    def __init__(
        self, classified: ClassifiedProblem, groups: Groups, find: FindFragments, *, resumes: bool = False
    ) -> None:
        """:param resumes: see `PlanningRequest`."""
        self._resumes = resumes
        self._problem = classified.problem
        self._facts = self._problem.facts
        self._groups = groups
        self._return_home = ReturnHome(classified)
        self._find = find
        self.has_blocking = False

    def ways(self, tasks: Sequence[Group]) -> Mapping[Group, Sequence[Fragment]] | list[Group]:
        """The fragments of each open task, none of which moves another task's things; else a list of tasks that
        must be merged, or of the one task that has no fragment.

        A group that stands in the way takes part even if its goals hold, or if it has none.
        """
        found: dict[Group, list[Fragment]] = {}
        away: dict[Group, Sequence[PlacesAside]] = {}
        places: dict[Group, dict[Goals, None]] = defaultdict(dict)
        everything = [*tasks, *self._groups.idle]
        for task in tasks:
            if not self._groups.is_open(task, self._facts):
                continue
            things = [each for each in everything if each != task]
            free, away[task] = self._guessed(task, things)
            if not free:
                straight = self._straight(task, tasks, things)
                free, away[task] = self._freed(task, straight, things)
            if not free:
                moved = [self._groups.moved(f.actions, [t for t in tasks if t != task]) for f in straight]
                free = [f for f, others in zip(straight, moved, strict=True) if not others]
                if not free:
                    return [task, *min(moved, key=len, default=())]
            found[task] = list(free)
            for aside in away[task]:
                for other, place in aside.items():
                    places[other][place] = None
        self.has_blocking = bool(places)
        for other, used in places.items():
            things = [each for each in everything if each != other]
            over = self._over(other, tuple(used), [*away.get(other, ()), {}], things)
            ways = [
                *found.get(other, [NO_ACTIONS]),
                *sorted(over, key=lambda way: way.duration_s)[:MAX_DETOURS],
            ]
            found[other] = list({tuple(map(str, way.actions)): way for way in ways}.values())
        return found

    def _straight(self, task: Group, tasks: Sequence[Group], things: Sequence[Group]) -> Sequence[Fragment]:
        """The task's fragments from the initial facts, or from those after agents have brought what they hold to its
        goals, and others what can be brought then, if only those leave the others' things alone.

        From the facts of a mission under way nobody may have its hands free, or what others are to fetch lies in
        between; to put everything aside first is a long search, for what scheduling does better: an agent turns to
        another task once its own is done.
        """
        others = [one for one in tasks if one.goals and one != task]
        held = [one for one in others if self._groups.is_held(one)]
        if held or self._groups.is_held(task) or self._resumes:
            near = self._find(self._facts, task.goals, levels=SMALLEST_WORLD_ONLY)
            if all(self._groups.moved(one.actions, things) for one in near):
                after_held = self._brought(self._facts, held, [task, *things])
                after_all = self._brought(after_held, others, [task, *things])
                for levels in (SMALLEST_WORLD_ONLY, ALL_LEVELS):
                    for facts in (after_held, after_all):
                        found = self._find(facts, task.goals, levels=levels)
                        if any(not self._groups.moved(one.actions, things) for one in found):
                            return found
        return self._find(self._facts, task.goals)

    def _brought(
        self, facts: frozenset[Fact], groups: Sequence[Group], things: Sequence[Group]
    ) -> frozenset[Fact]:
        """The facts once those of the groups are at their goals that can be brought there without moving others, those
        brought first making way for the rest. What agents hold that cannot is put down on its way.
        """
        waiting = [group for group in groups if self._groups.is_open(group, facts)]
        held = [group for group in waiting if self._groups.is_held(group)]
        while waiting:
            carried = [one for one in held if one in waiting]
            way = self._way(facts, _to_goals(waiting), things, SMALLEST_WORLD_ONLY) or self._way(
                facts, _to_goals(carried), things
            )
            if way is not None:
                waiting.remove(way[0])
            elif (way := self._way_down(facts, carried)) is not None:
                held.remove(way[0])
            else:
                break
            facts = self._return_home.after(facts, way[1])
        return facts

    def _way(
        self,
        facts: frozenset[Fact],
        places: Iterable[tuple[Group, Goals]],
        things: Sequence[Group],
        levels: int = ALL_LEVELS,
    ) -> tuple[Group, Sequence[GroundAction]] | None:
        """The first of the groups that can be brought to its place without moving others, and how."""
        for group, place in places:
            others = [each for each in things if each != group]
            for way in self._find(facts, place, levels=levels):
                if not self._groups.moved(way.actions, others):
                    return group, way.actions
        return None

    def _way_down(
        self, facts: frozenset[Fact], groups: Sequence[Group]
    ) -> tuple[Group, Sequence[GroundAction]] | None:
        """The first of these groups, which agents hold, that can be put down on its way, and how."""
        for group in groups:
            for way in self._find(facts, group.goals):
                actions = self._groups.putting_down(way.actions, group)
                if actions and fault_of(actions, facts, ()) is None:
                    return group, actions
        return None

    def _guessed(
        self, task: Group, things: Sequence[Group]
    ) -> tuple[Sequence[Fragment], Sequence[PlacesAside]]:
        """The task's fragments from the facts after its place is cleared, if it must be and known fragments clear
        it; saves the search for a way to clear it."""
        asides = self._guess(task, things, ())
        if not asides or not self._made_way(task, things, [asides], SMALLEST_WORLD_ONLY):
            return (), ()
        free = self._made_way(task, things, [asides])
        if any(fault_of(fragment.actions, self._facts, ()) is None for fragment in free):
            return (), ()
        return free, [asides, self._guess(task, things, asides.values()) or asides]

    def _guess(self, task: Group, things: Sequence[Group], taken: Collection[Goals]) -> PlacesAside:
        """A free place elsewhere for each group that lies at the task's place; empty if one has none."""
        beside = self._groups.linked_by_fluents(task)
        asides: dict[Group, Goals] = {}
        for each in things:
            if not beside.isdisjoint(each.things):
                place = self._elsewhere(each, things, [*taken, *asides.values()])
                if not place:
                    return {}
                asides[each] = place
        return asides

    def _elsewhere(self, group: Group, things: Sequence[Group], taken: Collection[Goals]) -> Goals:
        """The nearest place like the present one to which known fragments bring the group's things."""
        others = [each for each in things if each != group]
        near = [
            (way.duration_s, place)
            for place in self._alike(group, self._groups.place(group))
            for way in self._find(self._facts, place, levels=0)
            if way.actions and place not in taken and not self._groups.moved(way.actions, others)
        ]
        return min(near, default=(0.0, ()))[1]

    def _freed(
        self, task: Group, straight: Sequence[Fragment], things: Sequence[Group]
    ) -> tuple[Sequence[Fragment], Sequence[PlacesAside]]:
        """The fragments that move no other things, else those from the facts after these are put aside."""
        free = [f for f in straight if not self._groups.moved(f.actions, things)]
        if free:
            return free, ()
        asides = list(self._places_aside(straight, things))
        return self._made_way(task, things, asides), asides

    def _places_aside(self, fragments: Sequence[Fragment], things: Sequence[Group]) -> Iterator[PlacesAside]:
        """Where the fragments that move the fewest other things put them."""
        moved = [self._groups.moved(fragment.actions, things) for fragment in fragments]
        least = min(map(len, moved), default=0)
        for fragment, groups in zip(fragments, moved, strict=True):
            put = {each: self._groups.put_aside(fragment.actions, each) for each in groups}
            if len(groups) == least and all(put.values()):
                yield put

    def _made_way(
        self, task: Group, things: Sequence[Group], asides: Sequence[PlacesAside], levels: int = ALL_LEVELS
    ) -> Sequence[Fragment]:
        """The task's fragments from the facts after things are put aside."""
        for aside in asides:
            cleared = self._cleared(aside, [task, *things])
            if cleared is not None:
                found = self._find(cleared, task.goals, levels=levels)
                free = [f for f in found if not self._groups.moved(f.actions, things)]
                if free:
                    return free
        return ()

    def _cleared(self, asides: PlacesAside, things: Sequence[Group]) -> frozenset[Fact] | None:
        """The facts once these things have been put aside; None if they cannot be without moving others."""
        facts = self._facts
        for aside in asides.items():
            way = self._way(facts, [aside], things, SMALLEST_WORLD_ONLY)
            if way is None:
                return None
            facts = self._return_home.after(facts, way[1])
        return facts

    def _over(
        self, group: Group, used: Sequence[Goals], away: Sequence[PlacesAside], things: Sequence[Group]
    ) -> Iterator[Fragment]:
        """Fragments that put a group's things aside first and then go on to its goals.

        :param used: where fragments have put them.
        :param away: what else may be put aside for its goals.
        """
        for place in dict.fromkeys(alike for one in used for alike in self._alike(group, one)):
            for asides in away:
                facts = self._cleared(asides, [group, *things])
                ways = (
                    ()
                    if facts is None
                    else self._through(
                        facts, group, place, things, SMALLEST_WORLD_ONLY if place in used else 0
                    )
                )
                if ways:
                    yield from ways
                    break

    def _through(
        self, facts: frozenset[Fact], group: Group, place: Goals, things: Sequence[Group], levels: int
    ) -> list[Fragment]:
        """Fragments that reach the group's goals via the place."""
        found = []
        for aside in self._find(facts, place, levels=levels)[:WAYS_ASIDE]:
            after = self._return_home.after(facts, aside.actions)
            for on in (
                self._find(after, group.goals, levels=levels)[:WAYS_ON] if group.goals else [NO_ACTIONS]
            ):
                actions = (*aside.actions, *on.actions)
                if not self._groups.moved(actions, things):
                    found.append(Fragment(goals=group.goals, actions=actions))
        return found

    def _alike(self, group: Group, place: Goals) -> Iterator[Goals]:
        """The place, and the same with another object of the same type."""
        yield place
        objects = self._problem.objects
        named = sorted({arg for fact in place for arg in fact.args if arg in objects} - group.things)
        for old in named:
            same = sorted(name for name, kind in objects.items() if kind == objects[old] and name != old)
            for new in same if len(same) < PLACES else ():
                yield tuple(fact.renamed({old: new}) for fact in place)


def _to_goals(groups: Iterable[Group]) -> Iterator[tuple[Group, Goals]]:
    return ((group, group.goals) for group in groups)
