"""The shipped knowledge base with places that are taken at the end of a way and free soon after its start."""

from functools import cache
from importlib import resources

from planner import KnowledgeBase
from planner.knowledge import read_knowledge_base

DRIVES = ("TRANSPORT", "NAVIGATE", "DOCK2", "CARRY")


@cache
def timed_store(*, lead: str = "start + 2", tail: str = "end - 2") -> KnowledgeBase:
    """Actions that drive need the place they go to only from `tail`, and leave the one they start from at `lead`."""
    text = (resources.files("planner.knowledge") / "files" / "rovers.yaml").read_text()
    first, *actions = text.split("  - identifier: ")
    return read_knowledge_base(
        "  - identifier: ".join([first, *(_timed(action, lead, tail) for action in actions)]), "timed store"
    )


def _timed(action: str, lead: str, tail: str) -> str:
    if not any(f"name: {name}\n" in action for name in DRIVES):
        return action
    needs, mark, changes = action.partition("    delete:\n")
    needs = needs.replace("clear(ref2, area)\n", f"clear(ref2, area) from {tail}\n")
    changes = changes.replace("clear(ref2, area)\n", f"clear(ref2, area) at {tail}\n")
    return needs + mark + changes.replace("clear(ref1, area)\n", f"clear(ref1, area) at {lead}\n")
