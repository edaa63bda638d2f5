"""What the robots of a world sense: as each says, or else as its sensors perceive. It decides how they keep in step."""

from collections.abc import Callable, Collection, Iterator, Mapping

from app.domain.errors import Invalid
from app.domain.world_model.vocabulary import symbolic_all, types_in
from planner import Fact, Keeping, KnowledgeBase, Ordering, PlanNet, Senses, awaits_of
from robots.world import RobotSpec, WorldFile
from robots.world.bodies import PackageBodySpec

Perceives = Callable[[Collection[str], Collection[str] | None], frozenset[str]]
"""By a robot's further sensors, and what they measure (None: not known), the predicates whose facts it perceives."""


def senses_of(robot: RobotSpec, perceives: Perceives) -> frozenset[str]:
    """The predicates, in rel/ref form, whose facts the robot senses.

    One with software of its own senses what it says: nothing, unless it does.
    """
    if robot.senses is not None or robot.external:
        return frozenset(robot.senses or ())
    measured = [sensor.measures for sensor in robot.sensors]
    stated = [one for one in measured if one is not None]
    is_known = len(stated) == len(measured) and not isinstance(robot.body, PackageBodySpec)
    quantities = frozenset[str]().union(*stated) if is_known else None
    return perceives({sensor.kind for sensor in robot.sensors}, quantities)


def restricted_senses(
    world: WorldFile, knowledge_base: KnowledgeBase, perceives: Perceives | None = None
) -> Senses:
    """What robots sense, of those that do not sense all that the knowledge base calls sensed.

    :param perceives: None: robots that do not say what they sense, sense all.
    """
    every = knowledge_base.sensed_words
    perceives = perceives or (lambda sensors, quantities: every)
    senses = {robot.name: senses_of(robot, perceives) for robot in world.robots}
    return {name: words & every for name, words in senses.items() if not every <= words}


def unsensed(net: PlanNet, senses: Senses, knowledge_base: KnowledgeBase) -> Iterator[str]:
    """Where the plan-net relies on a robot to sense what it does not sense now, in words with the way out.

    :param senses: as `restricted_senses` gives them now.
    """
    if not any(robot in senses for robot in net.robots):
        return
    for (action, robot), facts in awaited_facts(net, knowledge_base).items():
        for fact in symbolic_all(facts, knowledge_base):
            if robot in senses and fact.predicate not in senses[robot]:
                yield (
                    f"{robot} is to sense {fact} before {action} {net.action(action).tag}, and senses "
                    f"{', '.join(sorted(senses[robot])) or 'nothing'}: plan again, or name {fact.predicate} in the "
                    f"senses of {robot}"
                )


def awaited_facts(net: PlanNet, knowledge_base: KnowledgeBase) -> Mapping[tuple[str, str], tuple[Fact, ...]]:
    """By action id and robot, the conditions of its part that other robots bring about and that it senses."""
    changed = (fact for action in net.actions for fact in (*action.deletes, *action.effects))
    facts = [*changed, *(fact for action in net.actions for fact in action.preconditions)]
    return awaits_of(net, types_in(facts, knowledge_base), knowledge_base)


def why_cleared(net: PlanNet, knowledge_base: KnowledgeBase) -> Mapping[tuple[str, str], str]:
    """By the two actions of each ordering that clearance keeps, why no robot senses that it may begin."""
    changed = (fact for action in net.actions for fact in (*action.deletes, *action.effects))
    needed = (fact for action in net.actions for fact in action.preconditions)
    types = types_in([*changed, *needed], knowledge_base)
    return {
        (one.before, one.after): "; ".join(
            dict.fromkeys(_unperceived(net, one, robot, types, knowledge_base) for robot in waiting)
        )
        for one in net.orderings
        if one.kept_by is Keeping.CLEARANCE
        for waiting in [_waiting(net, one)]
    }


def _waiting(net: PlanNet, ordering: Ordering) -> list[str]:
    """The robots of the later action that have to learn that others have ended the earlier one."""
    return [one for one in net.action(ordering.after).agents if net.action(ordering.before).agents != (one,)]


def _unperceived(
    net: PlanNet, ordering: Ordering, robot: str, types: Mapping[str, str], knowledge_base: KnowledgeBase
) -> str:
    links = [
        link.fact
        for link in net.causal_links
        if (link.producer, link.consumer) == (ordering.before, ordering.after)
    ]
    if not links:
        return f"{robot} needs no fact that {ordering.before} brings about"
    words = net.senses.get(robot)
    able = [fact for fact in links if knowledge_base.is_sensed(fact, types)]
    missing = able or links
    facts = " and ".join(str(fact) for fact in symbolic_all(missing, knowledge_base))
    if not able:
        return f"no robot senses {facts}"
    if any(knowledge_base.is_sensed(fact, types, words) for fact in able):
        return f"{robot} senses {facts}, which may be true before {ordering.before} has ended"
    told = "nothing" if not words else f"only {', '.join(sorted(words))}"
    return f"{robot} does not sense {facts}: it senses {told}"


def refuse_unknown_senses(robot: RobotSpec, knowledge_base: KnowledgeBase) -> None:
    """:raises Invalid: if the robot says to sense what is no predicate in rel/ref form."""
    known = knowledge_base.relation_names()
    if (wrong := next((word for word in robot.senses or () if word not in known), None)) is not None:
        raise Invalid(
            f"robots.{robot.name}.senses: unknown predicate {wrong!r}; choices: {', '.join(known)}",
            code="unknown-predicate",
            choices=known,
            thing=wrong,
        )
