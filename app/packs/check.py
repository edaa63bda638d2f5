"""Checks a domain pack together with those that it needs."""

from collections.abc import Callable, Iterator

from app.domain.errors import Invalid
from app.domain.mission_organiser import load_library
from app.domain.world_model import initial_facts
from app.domain.world_model.numbers import initial_numbers
from app.packs.contents import contents_of
from app.packs.errors import PackError
from app.packs.pack import Pack
from app.packs.pack_set import Packs
from planner import KnowledgeBase, KnowledgeBaseError
from robots.conditions.facts import ALWAYS_SENSED
from robots.deliberative.rule_set import check_rule_set
from robots.repertoire.schema import TIMEOUT, TOO_FAR, TOO_FAST
from robots.world import WorldFileError, load_world


def faults_of(packs: Packs) -> Iterator[str]:
    """What is wrong with the packs, each fault with its file, line, slot and choices."""
    reads: tuple[Callable[[], object], ...] = (packs.knowledge_base, packs.repertoire, packs.worlds)
    broken = [fault for read in reads if (fault := _fault(read))]
    if not broken:
        broken = [fault for read in (packs.library, packs.verbs) if (fault := _fault(read))]
    if broken:
        yield from broken
        return
    knowledge_base = packs.knowledge_base()
    for pack in packs.packs:
        yield from _unachieved(pack, packs)
        yield from _unraised(pack, packs)
        yield from _unsensed(pack, packs)
        yield from _world_faults(pack, packs, knowledge_base)


def _fault(read: Callable[[], object]) -> str | None:
    try:
        read()
    except PackError as error:
        return error.detail
    return None


def _unachieved(pack: Pack, packs: Packs) -> Iterator[str]:
    """The actions that no robot could be sent to carry out."""
    knowledge_base = packs.knowledge_base()
    achieved = packs.library().index.keys()
    for name in contents_of(pack).actions:
        effects = [
            effect
            for variant in knowledge_base.actions[name].variants
            for effect in knowledge_base.actions[name].literals("intended_effects", variant)
        ]
        if not any(effect.predicate in achieved for effect in effects):
            wanted = ", ".join(dict.fromkeys(map(str, effects)))
            files = ", ".join(map(str, pack.knowledge_bases))
            yield f"{files}: {name}: no packet of a behaviours library achieves any of {wanted}"
        for predicate in knowledge_base.between_phases_of(name):
            if predicate not in achieved:
                files = ", ".join(map(str, pack.knowledge_bases))
                yield f"{files}: {name} has phases: no packet of a behaviours library achieves {predicate}"


def _unraised(pack: Pack, packs: Packs) -> Iterator[str]:
    """The events in the pack's behaviours library that their packet never raises."""
    raised: dict[str, set[str]] = {}
    for spec in packs.repertoire().specs.values():
        raised.setdefault(spec.tag, {TOO_FAST, TOO_FAR, TIMEOUT}).update(spec.events)
    for entry in load_library(packs.knowledge_base(), *pack.libraries).entries if pack.libraries else ():
        for name, _ in entry.events:
            if name not in raised[entry.tag]:
                files = ", ".join(map(str, pack.libraries))
                choices = ", ".join(sorted(raised[entry.tag]))
                yield f"{files}: {entry.tag}: its packet raises no event {name!r}; choices: {choices}"


def _unsensed(pack: Pack, packs: Packs) -> Iterator[str]:
    """The predicates that robots are said to perceive, and none can."""
    known = {one.predicate for one in packs.repertoire().sensed} | ALWAYS_SENSED
    predicates = packs.knowledge_base().predicates
    for name in contents_of(pack).predicates:
        if predicates[name].sensed and not predicates[name].relational and name not in known:
            files = ", ".join(map(str, pack.knowledge_bases))
            yield f"{files}: predicates.{name}: it is sensed, but no file of a repertoire says by which condition"


def _world_faults(pack: Pack, packs: Packs, knowledge_base: KnowledgeBase) -> Iterator[str]:
    repertoire = packs.repertoire()
    for path in pack.worlds.values():
        try:
            world = load_world(
                path,
                worlds={},
                tags=repertoire.tags,
                check_tuning=repertoire.tuned,
                check_rules=lambda files: check_rule_set(files, repertoire),
            )
            initial_facts(world, knowledge_base)
            initial_numbers(world, knowledge_base)
        except WorldFileError as error:
            yield str(error)
        except (KnowledgeBaseError, Invalid) as error:
            yield f"{path} is not a valid world: facts: {error}"
