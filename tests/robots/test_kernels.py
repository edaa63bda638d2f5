"""The cache of compiled functions depends on the sources of everything that is compiled."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

import robots.kernels
from robots.kernels import KEPT_FOLDERS, UNUSED_S, VARIABLE, KernelsError, install

HELPER = """
from numba.extending import register_jitable

from small.measures import FACTOR

@register_jitable
def scaled(x):
    return {value} * x * FACTOR
"""
KERNEL = """
import numba

from small.a import scaled

@numba.njit(cache=True)
def kernel(x):
    return scaled(x) + 1
"""
RUN = """
import sys
from pathlib import Path
if {installed}:
    from robots.kernels import install
    install([Path("small").absolute()])
from small.b import kernel
print(kernel(10), sum(kernel.stats.cache_hits.values()))
"""
ROOT = Path(__file__).parents[2]


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A package with a kernel in one module, a compiled helper in another and a constant in a third."""
    package = tmp_path / "small"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "measures.py").write_text("FACTOR = 1\n")
    (package / "a.py").write_text(HELPER.format(value=2))
    (package / "b.py").write_text(KERNEL)
    return package


def run(small: Path, *, installed: bool = True) -> tuple[int, int]:
    """What the kernel returns in a process of its own, and how often its machine code came from the cache."""
    environment = {
        **os.environ,
        "PYTHONPATH": f"{ROOT}{os.pathsep}{small.parent}",
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    environment[VARIABLE] = str(small.parent / "cache")
    done = subprocess.run(
        [sys.executable, "-c", RUN.format(installed=installed)],
        cwd=small.parent,
        env=environment,
        check=True,
        capture_output=True,
        text=True,
    )
    value, hits = done.stdout.split()
    return int(value), int(hits)


def test_numba_alone_runs_stale_code_after_a_called_function_was_edited(small: Path) -> None:
    """What the cache folder is for; if this fails, numba notices by itself and `robots.kernels` may go."""
    assert run(small, installed=False) == (21, 0)
    (small / "a.py").write_text(HELPER.format(value=3))
    assert run(small, installed=False) == (21, 1)


def test_a_kernel_is_compiled_again_when_a_function_that_it_calls_was_edited(small: Path) -> None:
    assert run(small) == (21, 0)
    assert run(small) == (21, 1)
    (small / "a.py").write_text(HELPER.format(value=3))
    assert run(small) == (31, 0)


def test_a_kernel_is_compiled_again_when_an_imported_constant_was_edited(small: Path) -> None:
    assert run(small) == (21, 0)
    (small / "measures.py").write_text("FACTOR = 5\n")
    assert run(small) == (101, 0)


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of its own; numba's setting is put back afterwards."""
    base = tmp_path / "cache"
    monkeypatch.setenv(VARIABLE, str(base))
    numba = pytest.importorskip("numba")
    monkeypatch.setattr(numba.config, "CACHE_DIR", numba.config.CACHE_DIR)
    return base


def test_processes_that_are_started_inherit_the_folder(small: Path, cache: Path) -> None:
    folder = install([small])
    assert folder.parent == cache
    assert os.environ[VARIABLE] == str(folder)
    assert install([small]) == folder


def test_an_edit_that_compiled_code_does_not_depend_on_changes_nothing(small: Path, cache: Path) -> None:
    folder = install([small])
    (small / "other.py").write_text("from small.b import kernel\n")
    assert install([small]) == folder
    (small / "b.py").write_text(KERNEL + "\n\n")
    assert install([small]) != folder


def test_another_version_of_numba_has_a_folder_of_its_own(
    small: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = install([small])
    monkeypatch.setattr(robots.kernels, "version", lambda name: "0.0")
    assert install([small]) != folder


def test_the_user_s_cache_is_used_unless_another_is_set(
    small: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(VARIABLE)
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    assert install([small]).parent == cache / "macta"


def test_it_is_too_late_once_a_kernel_is_imported(
    small: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "small.b", sys)
    with pytest.raises(KernelsError, match=r"before small\.b is imported"):
        install([small])


def test_old_folders_are_removed_but_not_recent_ones_nor_other_files(small: Path, cache: Path) -> None:
    old_s = time.time() - 2 * UNUSED_S
    old = [cache / f"kernels-{number}" for number in range(KEPT_FOLDERS + 2)]
    for number, folder in enumerate(old):
        folder.mkdir(parents=True)
        (folder / "code.nbi").touch()
        os.utime(folder, (old_s - number, old_s - number))
    recent = cache / "kernels-recent"
    recent.mkdir()
    (cache / "other").mkdir()
    folder = install([small])
    kept = {path.name for path in cache.iterdir()}
    newest = {one.name for one in old[: KEPT_FOLDERS - 2]}
    assert kept == {folder.name, recent.name, "other", *newest}
