"""Reads a knowledge base from YAML; errors name the file, the line, the action and the slot."""

from functools import lru_cache
from importlib import resources
from pathlib import Path

from pydantic import ValidationError

from planner.knowledge.base import KnowledgeBase
from planner.knowledge.document import Document, read_text
from planner.knowledge.schema import KnowledgeBaseFile


def shipped_knowledge_base() -> Path:
    """The file of the knowledge base that ships with Macta."""
    with resources.as_file(resources.files("planner.knowledge") / "files" / "rovers.yaml") as path:
        return path


def load_knowledge_base(path: str | Path | None = None) -> KnowledgeBase:
    """The knowledge base of a file, or the one that ships with Macta.

    :raises KnowledgeBaseError: if it is missing, not YAML, or does not fit the schema.
    """
    path = path or shipped_knowledge_base()
    return read_knowledge_base(read_text(path), str(path))


@lru_cache(maxsize=8)
def read_knowledge_base(text: str, origin: str) -> KnowledgeBase:
    """As `load_knowledge_base`, from the text itself; the same object for the same text."""
    document = Document.parse(text, origin)
    try:
        return KnowledgeBase(KnowledgeBaseFile.model_validate(document.data))
    except ValidationError as error:
        raise document.refused(error) from error
