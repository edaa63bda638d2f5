"""Where the machine code of compiled functions (numba) is cached.

numba recompiles a function if the function's own file has changed, but not if a function or constant that it uses from
another file has. So the cache is a folder named after a digest of all sources that compiled code depends on: an edit of
any of them gives a new folder. Entry points call `install` before they import anything that is compiled; processes that
they start inherit the folder through the environment. `robots.compilation` says which process compiles.
"""

import hashlib
import os
import platform
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = tuple(Path(__file__).parents[1] / name for name in ("planner", "robots", "sim"))
"""The packages that define compiled functions."""
VARIABLE = "NUMBA_CACHE_DIR"
PREFIX = "kernels-"
KEPT_FOLDERS = 4
UNUSED_S = 24 * 3600.0
"""Folders of other digests are removed when they are not among the newest and unused for this long (wall clock)."""

IMPORT = re.compile(r"^\s*(?:from\s+([\w.]+)\s+import\s+(\([^)]*\)|[^\n]*)|import\s+([\w.]+))", re.MULTILINE)
DECORATOR = re.compile(r"^\s*@(\w+)", re.MULTILINE)


class KernelsError(RuntimeError):
    """Raised when compiled functions are imported before their cache is installed; numba binds the folder then."""


def install(packages: Sequence[Path] = PACKAGES) -> Path:
    """Have numba cache machine code in the folder of the packages' present sources; old folders are removed.

    :param packages: folders of packages that stand side by side.
    :returns: the folder.
    :raises KernelsError: if a module with compiled functions is imported already, with another folder.
    """
    sources = _sources(packages)
    compiled = _compiled(sources)
    name = PREFIX + _digest(sources, _used_by(compiled, sources))
    present = os.environ.get(VARIABLE, "")
    if Path(present).name == name:
        return Path(present)
    if early := sorted(compiled & sys.modules.keys()):
        raise KernelsError(f"install the cache of compiled functions before {', '.join(early)} is imported")
    folder = _folder(name, _bases(present))
    os.environ[VARIABLE] = str(folder)
    if "numba" in sys.modules:
        setattr(sys.modules["numba"].config, "CACHE_DIR", str(folder))  # noqa: B010, its type declares no members
    _remove_unused(folder)
    return folder


def _sources(packages: Iterable[Path]) -> dict[str, bytes]:
    """Dotted module name to its source."""
    sources = {}
    for package in packages:
        for path in sorted(package.rglob("*.py")):
            parts = path.relative_to(package.parent).with_suffix("").parts
            sources[".".join(parts).removesuffix(".__init__")] = path.read_bytes()
    return sources


def _imports(source: str) -> Iterator[tuple[str, set[str]]]:
    """The modules that a source imports from, each with the names."""
    for module, names, whole in IMPORT.findall(source):
        yield (module or whole), set(re.findall(r"\w+", names))


def _compiled(sources: Mapping[str, bytes]) -> set[str]:
    """The modules with compiled functions: those that import numba, or decorate with a name from one that does."""
    texts = {name: source.decode() for name, source in sources.items()}
    direct = {
        name
        for name, text in texts.items()
        if "numba" in text and any(module.split(".")[0] == "numba" for module, _ in _imports(text))
    }
    by_decorator = {
        name
        for name, text in texts.items()
        if any(module in direct and names & set(DECORATOR.findall(text)) for module, names in _imports(text))
    }
    return direct | by_decorator


def _used_by(compiled: set[str], sources: Mapping[str, bytes]) -> set[str]:
    """The compiled modules and those of ours that they import, through packages' faces."""
    used = set(compiled)
    waiting = list(compiled)
    while waiting:
        for module, names in _imports(sources[waiting.pop()].decode()):
            for name in (module, *(f"{module}.{one}" for one in names)):
                if name in sources and name not in used:
                    used.add(name)
                    is_face = any(other.startswith(f"{name}.") for other in sources)
                    waiting += [name] if is_face else []
    return used


def _digest(sources: Mapping[str, bytes], names: Iterable[str]) -> str:
    digest = hashlib.sha256(f"{platform.python_version()} {_compiler()}".encode())
    for name in sorted(names):
        digest.update(f"\0{name}\0".encode())
        digest.update(sources[name])
    return digest.hexdigest()[:16]


def _bases(present: str) -> Iterator[Path]:
    """Where the folder may lie: as the environment says, in the user's cache, in the temporary folder."""
    if present:
        yield Path(present).parent if Path(present).name.startswith(PREFIX) else Path(present)
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    yield home / "macta"
    yield Path(tempfile.gettempdir()) / f"macta-{os.getuid()}"


def _compiler() -> str:
    """numba's version; empty if it is not installed."""
    try:
        return version("numba")
    except PackageNotFoundError:
        return ""


def _folder(name: str, bases: Iterable[Path]) -> Path:
    """The first of the folders that can be written, marked as used now."""
    for base in bases:
        folder = base / name
        try:
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            if os.access(folder, os.W_OK):
                os.utime(folder)
                return folder
        except OSError:
            continue
    return Path(tempfile.mkdtemp(prefix=f"macta-{name}-"))


def _remove_unused(current: Path) -> None:
    """Remove all but the newest folders. One in use by another process is too new to be removed; if it is removed all
    the same, numba compiles again.
    """
    before_s = time.time() - UNUSED_S
    used_s = {}
    for folder in current.parent.glob(f"{PREFIX}*"):
        try:
            used_s[folder] = folder.stat().st_mtime
        except OSError:  # another process has removed it
            continue
    newest = sorted(used_s, key=used_s.__getitem__, reverse=True)
    for folder in newest[KEPT_FOLDERS:]:
        if folder != current and used_s[folder] < before_s:
            shutil.rmtree(folder, ignore_errors=True)
