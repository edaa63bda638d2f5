"""The shipped knowledge base for robots that all carry their drives out in phases, with times to choose."""

import re
from functools import cache
from importlib import resources

from planner import KnowledgeBase
from planner.knowledge import read_knowledge_base


@cache
def timed_store(*, lead: str = "start + 2", tail: str = "end - 2") -> KnowledgeBase:
    """Actions that drive need the place they go to only from `tail`, and leave the one they start from at `lead`."""
    text = (resources.files("planner.knowledge") / "files" / "rovers.yaml").read_text()
    text = re.sub(r"\n    phases_when: .*", "", text)
    text = re.sub(r"\) (from|at) end - \d+\n", rf") \1 {tail}\n", text)
    return read_knowledge_base(re.sub(r"\) at start \+ \d+\n", f") at {lead}\n", text), "timed store")
