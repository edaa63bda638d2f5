"""What the documents name exists: modules, folders and tests."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
DOCUMENTS = sorted(path.relative_to(ROOT) for path in (*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")))
TEST = re.compile(r"`(?P<path>[\w./]*test_\w+\.py)(?:::(?P<name>test_\w+))?`")
PLACE = re.compile(
    r"`(?P<path>(?:app|planner|robots|sim|web|tests|benchmarks|examples)/[\w./]*)(?::[\w.]+)?`"
)


def named(document: Path, pattern: re.Pattern[str]) -> Iterator[re.Match[str]]:
    yield from pattern.finditer((ROOT / document).read_text())


@pytest.mark.parametrize("document", DOCUMENTS, ids=str)
def test_modules_and_folders_that_a_document_names_exist(document: Path) -> None:
    missing = [
        match["path"]
        for match in named(document, PLACE)
        if not any((ROOT / base / match["path"]).exists() for base in ("", "tests"))
    ]
    assert missing == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=str)
def test_tests_that_a_document_names_exist(document: Path) -> None:
    missing = []
    for match in named(document, TEST):
        path = next(
            (ROOT / base / match["path"] for base in ("tests", "") if (ROOT / base / match["path"]).exists()),
            None,
        )
        if path is None or (match["name"] and f"def {match['name']}(" not in path.read_text()):
            missing.append(match[0])
    assert missing == []
