"""The states of goals, plans, missions, scripts, recoveries and holds are assigned by their life cycles alone."""

import ast
from collections.abc import Iterator
from pathlib import Path

import app

OWNED = {
    "goal": {"state", "reason", "outcome", "mission_id", "waits_for"},
    "plan": {"state", "reason", "comment", "decided_by", "decided_at"},
    "mission": {
        *{"state", "resume_to", "is_overdue", "ended_at_s"},
        *{"recovery_step", "attempts", "tries_left", "stopped_for", "replanning"},
    },
    "script": {
        *{"delivery", "state", "stopping", "abandoned", "control", "control_number", "question"},
        *{"category", "perceived", "heard_at_s", "doubt"},
    },
    "hold": {"state", "ending", "ended_by", "ended_at"},
}
ROOT = Path(app.__file__).parent


def assigned(tree: ast.AST) -> Iterator[ast.Attribute]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node


def test_no_other_module_assigns_a_state() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{target.lineno} {ast.unparse(target)}"
        for path in ROOT.rglob("*.py")
        if "lifecycles" not in path.parts
        for target in assigned(ast.parse(path.read_text()))
        if isinstance(target.value, ast.Name) and target.attr in OWNED.get(target.value.id, ())
    ]
    assert found == []
