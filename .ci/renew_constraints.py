# /// script
# requires-python = ">=3.11"
# ///
"""Resolve all dependencies again and write the versions into pyproject.toml: `uv run .ci/renew_constraints.py`.

Of the environment, all extras and groups included, and of what builds the wheel. Only names and versions are written:
where they come from is up to who installs them.
"""

import re
import subprocess
import tempfile
import tomllib
from pathlib import Path

PYPROJECT = Path(__file__).parents[1] / "pyproject.toml"
MEMBER = Path("robots") / "pyproject.toml"
BUILD = """
[project]
name = "build"
version = "0"
requires-python = "{python}"
dependencies = {requires}
"""
EDITABLES = "editables"
"""What hatchling asks for besides where it installs a project from its folder."""


def block(name: str) -> re.Pattern[str]:
    return re.compile(rf"^{name} = \[\n.*?^\]\n", re.MULTILINE | re.DOTALL)


def with_list(text: str, name: str, entries: list[str]) -> str:
    lines = "".join(f'    "{entry}",\n' for entry in entries)
    text, count = block(name).subn(f"{name} = [\n{lines}]\n", text)
    assert count == 1, name
    return text


def resolved(pyproject: str) -> list[str]:
    """The newest versions that go together, as `name==version`."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "pyproject.toml").write_text(pyproject)
        (Path(folder) / MEMBER).parent.mkdir()
        (Path(folder) / MEMBER).write_text((PYPROJECT.parent / MEMBER).read_text())
        subprocess.run(["uv", "lock", "--quiet", "--project", folder], check=True)
        packages = tomllib.loads((Path(folder) / "uv.lock").read_text())["package"]
    return [f"{one['name']}=={one['version']}" for one in packages if "registry" in one["source"]]


def main() -> None:
    text = PYPROJECT.read_text()
    settings = tomllib.loads(text)
    requires = [*settings["build-system"]["requires"], EDITABLES]
    build = BUILD.format(python=settings["project"]["requires-python"], requires=requires)
    free = with_list(text, "constraint-dependencies", [])
    text = with_list(text, "constraint-dependencies", resolved(free))
    PYPROJECT.write_text(with_list(text, "build-constraint-dependencies", resolved(build)))


if __name__ == "__main__":
    main()
