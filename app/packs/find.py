"""Finds domain packs: those that ship, those of installed packages, and folders."""

from collections.abc import Iterator, Mapping, Sequence
from importlib import resources
from importlib.metadata import EntryPoint
from importlib.util import find_spec
from pathlib import Path

from app.domain.mission_organiser import shipped_library
from app.packs import MAIN_WORLD, SHIPPED, STORE, SURVEY
from app.packs.errors import PackError
from app.packs.extensions import PACKS
from app.packs.pack import VERBS, Pack, read_pack
from app.packs.pack_set import Packs
from planner import shipped_knowledge_base
from robots.errors import ExtensionError
from robots.extensions import described, installed
from robots.world import shipped_worlds

STORE_VERSION = "1.0"
"""Counts the changes of its vocabulary that packs resting on it could notice."""
SHIPS = "ships with Macta"


def store_pack() -> Pack:
    """The pack whose files lie where the parts that read them lie, not in one folder."""
    worlds = shipped_worlds()
    return Pack(
        name=STORE,
        version=STORE_VERSION,
        place=STORE,
        source=SHIPS,
        about="The sample store and the object relocation task.",
        example="move sample_1 to bay_7",
        knowledge_bases=(shipped_knowledge_base(),),
        libraries=(shipped_library(),),
        packets=_shipped_packets(),
        verbs=(_shipped_verbs(),),
        worlds={MAIN_WORLD: worlds[MAIN_WORLD], **worlds},
    )


def survey_pack() -> Pack:
    """The pack that is a folder beside this module."""
    with resources.as_file(resources.files("app.packs") / SURVEY) as folder:
        return read_pack(folder, shipped_as=SHIPS)


def _shipped_packets() -> tuple[Path, ...]:
    """As `robots.repertoire.store_packets`, without the packets' software, whose import takes a third of a second."""
    with resources.as_file(resources.files("robots") / "repertoire" / "store") as folder:
        return tuple(sorted(folder.glob("*.yaml")))


def _shipped_verbs() -> Path:
    with resources.as_file(resources.files("app.domain.goal_language") / VERBS) as path:
        return path


def load_packs(names: Sequence[str]) -> Packs:
    """The packs of these names or folders, with all that they need, each after those that it needs.

    A name is that of an installed pack, if there is one, else a folder.

    :raises PackError: if one is missing, not valid, too old, or needs itself.
    """
    found: dict[str, Pack] = {}
    for name in names:
        pack = find_pack(name)
        other = found.setdefault(pack.name, pack)
        if other.source != pack.source:
            raise PackError(f"two packs are named {pack.name}: {other.source}, and {pack.source}")
    return Packs(tuple(_in_order(found)))


def installed_names() -> tuple[str, ...]:
    """The names of the packs that ship and of those of installed packages."""
    return (*SHIPPED, *sorted(_entries()))


def _entries() -> Mapping[str, EntryPoint]:
    try:
        return installed(PACKS)
    except ExtensionError as error:
        raise PackError(str(error)) from error


def find_pack(name: str) -> Pack:
    """The pack of a name or folder, without those that it needs.

    :raises PackError: if it is missing or not valid.
    """
    if name == STORE:
        return store_pack()
    if name == SURVEY:
        return survey_pack()
    if (entry := _entries().get(name)) is not None:
        pack = read_pack(_folder_of(entry), shipped_as=f"package {described(entry)}")
        if pack.name != name:
            raise PackError(f"{pack.source} registers the pack {pack.name} as {name}")
        return pack
    folder = Path(name).resolve()
    if not folder.is_dir():
        raise PackError(f"no domain pack or folder {name!r}", choices=installed_names())
    return read_pack(folder)


def _folder_of(entry: EntryPoint) -> Path:
    """The folder of the package that an entry point names, whose own code is not run for it."""
    try:
        spec = find_spec(entry.value)
    except (ImportError, ValueError) as error:
        raise PackError(f"{PACKS}: {entry.name}: {described(entry)}: {error}") from error
    if spec is None or not spec.submodule_search_locations:
        raise PackError(f"{PACKS}: {entry.name}: {described(entry)} is no package of modules with a folder")
    return Path(spec.submodule_search_locations[0])


def _in_order(found: dict[str, Pack]) -> Iterator[Pack]:
    """The packs and those that they need, the needed ones first."""
    done: set[str] = set()

    def visit(name: str, users: tuple[Pack, ...]) -> Iterator[Pack]:
        if any(user.name == name for user in users):
            line = " needs ".join((*(user.name for user in users), name))
            raise PackError(f"a domain pack needs itself: {line}")
        if name in done:
            return
        pack = found.get(name) or _needed(name, users[-1])
        found[name] = pack
        for need, version in pack.needs.items():
            yield from visit(need, (*users, pack))
            if not found[need].is_at_least(version):
                raise PackError(
                    f"pack {pack.name} ({pack.source}) needs {need} {version} or later; "
                    f"{found[need].source} is {found[need].version}"
                )
        done.add(name)
        yield pack

    for name in list(found):
        yield from visit(name, ())


def _needed(name: str, user: Pack) -> Pack:
    if name not in installed_names():
        raise PackError(
            f"pack {user.name} ({user.source}) needs the pack {name}, which is not installed; name its folder as well",
            choices=installed_names(),
        )
    return find_pack(name)
