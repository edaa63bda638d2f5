"""Groups goals by their subject: the things that are moved or worked on, or where agents end."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from planner.engines.hierarchical.legs.leg import ClassifiedProblem
from planner.fact import Fact
from planner.knowledge import GroundAction

Goals = tuple[Fact, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """Goals on the same things (none: on where agents end), or things that no goal is about."""

    things: frozenset[str]
    goals: Goals = ()

    @classmethod
    def of(cls, groups: Iterable["Group"]) -> "Group":
        """Several groups as one."""
        parts = tuple(groups)
        things = frozenset(thing for part in parts for thing in part.things)
        return cls(things=things, goals=tuple(goal for part in parts for goal in part.goals))


class Groups:
    """A problem's goals, those on the same thing or on the same agents' configuration together (`wanted`), and the
    things beside (`idle`)."""

    def __init__(self, classified: ClassifiedProblem) -> None:
        self._classified = classified
        problem = classified.problem
        self.wanted = tuple(self._grouped(problem.goals))
        busy = {thing for group in self.wanted for thing in group.things}
        self._about: dict[str, list[Fact]] = defaultdict(list)
        self._lying: dict[str, set[str]] = defaultdict(set)
        for fact in filter(classified.is_fluent, problem.facts):
            things = classified.things.intersection(fact.args)
            for thing in things:
                self._about[thing].append(fact)
            for arg in problem.objects.keys() & set(fact.args) - things:
                self._lying[arg] |= things
        self.idle = tuple(Group(things=frozenset([thing])) for thing in sorted(classified.things - busy))

    def _grouped(self, goals: Iterable[Fact]) -> Iterable[Group]:
        parts: list[tuple[frozenset[str], Group]] = []
        for goal in dict.fromkeys(goals):
            things = self._classified.things.intersection(goal.args)
            about = self._classified.agents_of(goal) if self._classified.is_configuration(goal) else things
            same = [part for part in parts if not part[0].isdisjoint(about)]
            parts = [part for part in parts if part not in same]
            joined = Group.of([*(group for _, group in same), Group(things=things, goals=(goal,))])
            parts.append((about.union(*(names for names, _ in same)), joined))
        return (group for _, group in parts)

    def is_final_configuration(self, group: Group) -> bool:
        """True if it is about where an agent ends."""
        return any(self._classified.is_configuration(goal) for goal in group.goals)

    def is_open(self, group: Group, facts: frozenset[Fact]) -> bool:
        """True if the group needs work; agents that leave may have to come back, so their goals always do."""
        return self.is_final_configuration(group) or not facts.issuperset(group.goals)

    def moved(self, actions: Sequence[GroundAction], groups: Iterable[Group]) -> list[Group]:
        """The groups whose things the actions change."""
        touched = {
            arg
            for action in actions
            for fact in (*action.deletes, *action.effects)
            for arg in self._classified.things.intersection(fact.args)
        }
        return [group for group in groups if not touched.isdisjoint(group.things)]

    def linked_by_fluents(self, group: Group) -> frozenset[str]:
        """The things that lie at the group's goals: a fact names them with an object of its goals."""
        named = {arg for goal in group.goals for arg in goal.args} - self._classified.agents
        return frozenset(
            thing for arg in named for thing in self._lying.get(arg, ()) if thing not in group.things
        )

    def place(self, group: Group) -> Goals:
        """The initial facts about the group's things; () if one of them names an agent."""
        if self.is_held(group):
            return ()
        return tuple(sorted(self._facts_about(group)))

    def is_held(self, group: Group) -> bool:
        """True if an initial fact about the group's things names an agent, such as the one that carries them."""
        return any(map(self._classified.agents_of, self._facts_about(group)))

    def put_aside(self, actions: Sequence[GroundAction], group: Group) -> Goals:
        """Where the actions first release a group's things: facts about these and no agent; () if nowhere."""
        return self._put_down(actions, group)[1]

    def putting_down(self, actions: Sequence[GroundAction], group: Group) -> Sequence[GroundAction]:
        """What those that hold a group's things do of the actions until they release these; () if they never do."""
        holding = frozenset[str]().union(*map(self._classified.agents_of, self._facts_about(group)))
        return [
            action
            for action in actions[: self._put_down(actions, group)[0]]
            if holding.issuperset(action.agents)
        ]

    def _facts_about(self, group: Group) -> frozenset[Fact]:
        """The initial facts about the group's things."""
        return frozenset(fact for thing in group.things for fact in self._about.get(thing, ()))

    def _put_down(self, actions: Sequence[GroundAction], group: Group) -> tuple[int, Goals]:
        """How many actions there are until they first release a group's things, and where; 0 and () if nowhere."""
        at_first = here = self._facts_about(group)
        for number, action in enumerate(actions, 1):
            here = here - set(action.deletes) | {
                fact for fact in action.effects if not group.things.isdisjoint(fact.args)
            }
            if here != at_first and not any(self._classified.agents_of(fact) for fact in here):
                return number, tuple(sorted(here - at_first))
        return 0, ()
