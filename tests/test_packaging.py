"""What an installation consists of: exact versions, packages that are left out, licences, files of the wheel."""

import tomllib
from collections.abc import Iterable, Iterator
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.test_architecture import OURS, imports, modules

ROOT = Path(__file__).parent.parent
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text())
PROJECT = SETTINGS["project"]
ROBOTS = tomllib.loads((ROOT / "robots" / "pyproject.toml").read_text())["project"]
RUNTIME = f"{ROBOTS['name']}=={ROBOTS['version']}"
UV = SETTINGS["tool"]["uv"]
EXTRAS = [requirement for extra in PROJECT["optional-dependencies"].values() for requirement in extra]
GROUPS = [requirement for group in SETTINGS["dependency-groups"].values() for requirement in group]
LEFT_OUT = {
    "unified-planning": {"configspace"},
    "viser": {"imageio", "requests", "tqdm", "trimesh"},
    "mcap": {"lz4"},
}
"""What these packages require and Macta's environment is without."""
MODULES = {"ConfigSpace", "scipy", "imageio", "PIL", "requests", "tqdm", "trimesh", "lz4"}
"""The modules of all that is left out."""
PERMISSIVE = {
    *("0BSD", "3-Clause BSD License", "BSD", "BSD-2-Clause", "BSD-3-Clause"),
    *("APACHE", "Apache-2.0", "Apache-2.0 WITH LLVM-exception"),
    *("CC0-1.0", "ISC License", "MIT", "MIT License", "PSF-2.0", "Zlib", "zlib"),
}
EXCEPTIONS = {"psycopg", "psycopg-binary"}
"""Argued in docs/licences.md."""


def required(package: Distribution, extras: Iterable[str] = ()) -> Iterator[Requirement]:
    """What an installed package requires on this machine."""
    for requirement in map(Requirement, package.requires or ()):
        wanted = ({"extra": extra} for extra in ("", *extras))
        if requirement.marker is None or any(requirement.marker.evaluate(extra) for extra in wanted):
            yield requirement


def closure(requirements: Iterable[str]) -> dict[str, Distribution]:
    """All installed packages that the requirements lead to."""
    packages: dict[str, Distribution] = {}
    seen = set[tuple[str, frozenset[str]]]()
    waiting = [Requirement(requirement) for requirement in requirements]
    while waiting:
        requirement = waiting.pop()
        name = canonicalize_name(requirement.name)
        if (name, frozenset(requirement.extras)) in seen or name == PROJECT["name"]:
            continue
        seen.add((name, frozenset(requirement.extras)))
        if name == ROBOTS["name"]:  # ours; what it requires counts
            waiting += required(distribution(name), requirement.extras)
            continue
        try:
            packages[name] = distribution(name)
        except PackageNotFoundError:
            continue
        left_out = LEFT_OUT.get(name, set())
        waiting += [
            one
            for one in required(packages[name], requirement.extras)
            if canonicalize_name(one.name) not in left_out
        ]
    return packages


DEFAULT = closure(PROJECT["dependencies"])


def test_every_installed_version_is_the_one_that_is_committed() -> None:
    committed = {*UV["constraint-dependencies"], *UV["build-constraint-dependencies"]}
    installed = closure([*PROJECT["dependencies"], *EXTRAS, *GROUPS])
    assert len(installed) > len(DEFAULT) > 50
    assert sorted({f"{name}=={one.version}" for name, one in installed.items()} - committed) == []


@pytest.mark.parametrize("name", ["constraint-dependencies", "build-constraint-dependencies"])
def test_a_committed_version_is_a_name_and_a_version(name: str) -> None:
    for entry in UV[name]:
        requirement = Requirement(entry)
        assert entry == f"{canonicalize_name(requirement.name)}=={next(iter(requirement.specifier)).version}"


def test_the_wheels_leave_their_users_a_choice_of_versions_but_for_each_other() -> None:
    robots = [
        *ROBOTS["dependencies"],
        *(one for extra in ROBOTS["optional-dependencies"].values() for one in extra),
    ]
    stated = [one for one in (*PROJECT["dependencies"], *EXTRAS, *robots) if "==" in one]
    assert stated == [RUNTIME]
    assert PROJECT["version"] == ROBOTS["version"]


@pytest.mark.parametrize("name", sorted(LEFT_OUT))
def test_the_requirements_that_are_written_for_a_package_are_its_own_but_for_those_left_out(
    name: str,
) -> None:
    (written,) = (entry["requires-dist"] for entry in UV["dependency-metadata"] if entry["name"] == name)
    own = {canonicalize_name(one.name): one.specifier for one in required(distribution(name))}
    kept = {key: specifier for key, specifier in own.items() if key not in LEFT_OUT[name]}
    assert {one.name: one.specifier for one in map(Requirement, written)} == kept
    assert LEFT_OUT[name] <= own.keys()


def test_the_product_imports_nothing_that_is_left_out() -> None:
    # ConfigSpace, by which unified-planning's own users are tested, and what schemathesis wants: nothing else is here.
    assert {name for name in MODULES if find_spec(name)} <= {"ConfigSpace", "scipy", "requests"}
    for package in sorted(OURS):
        for module in modules(package):
            assert MODULES.isdisjoint(name.partition(".")[0] for name in imports(module)), module


def licence(package: Distribution) -> str:
    """The licence as the package's metadata give it, in the newest form that they have."""
    metadata = package.metadata
    texts = [*(metadata.get_all("License-Expression") or ()), *(metadata.get_all("License") or ())]
    for text in texts:
        if "\n" not in text:
            return text
    return next(
        classifier.rpartition(" :: ")[2]
        for classifier in metadata.get_all("Classifier") or ()
        if classifier.startswith("License ::")
    )


def is_permissive(licences: str) -> bool:
    return any(PERMISSIVE.issuperset(choice.split(" AND ")) for choice in licences.split(" OR "))


def test_a_default_install_is_permissively_licensed() -> None:
    refused = {name for name, package in DEFAULT.items() if not is_permissive(licence(package))}
    assert refused == EXCEPTIONS


def test_the_notices_name_every_package_of_a_default_install() -> None:
    rows = [f"| {name} | {licence(package)} |" for name, package in sorted(DEFAULT.items())]
    page = (ROOT / "docs" / "licences.md").read_text().splitlines()
    noted = [line for line in page if line.startswith("| ")]
    assert [row for row in noted if row in rows] == rows, "\n".join(rows)
