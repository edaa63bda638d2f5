"""What each pack brings, by name."""

from collections.abc import Sequence

from pydantic import BaseModel

from app.domain.goal_language.verbs import VerbsError, load_verbs
from app.packs.errors import PackError
from app.packs.pack import Pack
from planner import KnowledgeBaseError, read_knowledge_base_part
from robots.errors import RepertoireError
from robots.repertoire import PacketSpec, SensedFacts, read_packet


class PackContents(BaseModel):
    """A pack and what it brings: names of actions, predicates, quantities and worlds, tags of packets, words of verbs.

    `senses` are facts that its robots perceive beside those that all do.

    `example` is a goal of its first world, as a sentence.

    `source` is the folder or the package that it comes from, `needs` other packs with the least version of each.
    """

    name: str
    version: str
    about: str
    example: str
    source: str
    needs: dict[str, str]
    actions: Sequence[str]
    predicates: Sequence[str]
    quantities: Sequence[str]
    packets: Sequence[str]
    senses: Sequence[str]
    verbs: Sequence[str]
    worlds: Sequence[str]


def contents_of(pack: Pack) -> PackContents:
    """:raises PackError: naming the file, the line and the slot of what is not valid."""
    try:
        parts = [read_knowledge_base_part(path) for path in pack.knowledge_bases]
        files = [read_packet(path) for path in pack.packets]
        verbs = sorted({word for path in pack.verbs for word in load_verbs(path).words})
    except (KnowledgeBaseError, RepertoireError, VerbsError) as error:
        raise PackError(str(error)) from error
    return PackContents(
        name=pack.name,
        version=pack.version,
        about=pack.about,
        example=pack.example,
        source=pack.source,
        needs=dict(pack.needs),
        actions=[action.name for part in parts for action in part.actions],
        predicates=[name for part in parts for name in part.predicates],
        quantities=[name for part in parts for name in part.quantities],
        packets=sorted({file.tag for file in files if isinstance(file, PacketSpec)}),
        senses=[one.fact for file in files if isinstance(file, SensedFacts) for one in file.sensed_facts],
        verbs=verbs,
        worlds=sorted(pack.worlds),
    )
