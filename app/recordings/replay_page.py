"""A recording as one standalone HTML file with the console's modules, styles and the data in it."""

import json
import posixpath
import re
from base64 import b64encode
from functools import partial
from html import escape
from pathlib import Path
from typing import Any

ENTRY = "replay/standalone.js"
STYLES = ("base", "layout", "plan", "world", "map", "replay", "results", "speech", "workbench")
IMPORT = re.compile(r'(?<= from )"(\.[^"]+)"')


def replay_page(static: Path, replay: dict[str, Any], *, title: str) -> str:
    """:param static: the folder of the console's files."""
    modules = _modules(static, ENTRY)
    addresses = {
        name: f"data:text/javascript;base64,{b64encode(text.encode()).decode()}"
        for name, text in modules.items()
    }
    style = "\n".join((static / "style" / f"{name}.css").read_text() for name in STYLES)
    # A "<" could end the element early.
    data = json.dumps(replay).replace("<", "\\u003c")
    return "\n".join(
        (
            '<!doctype html><html lang="en"><head><meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{escape(title)}</title><style>{style}</style>",
            f'<script type="importmap">{json.dumps({"imports": addresses})}</script>',
            f'<script type="application/json" id="replay">{data}</script>',
            f'</head><body><script type="module">import "{ENTRY}";</script></body></html>',
        )
    )


def _modules(static: Path, entry: str) -> dict[str, str]:
    """The module and all modules that it imports, by path; relative imports are rewritten to paths."""
    found: dict[str, str] = {}
    wanted = [entry]
    while wanted:
        name = wanted.pop()
        if name not in found:
            absolute = partial(_absolute, posixpath.dirname(name))
            found[name] = IMPORT.sub(absolute, (static / name).read_text())
            wanted += re.findall(r' from "([^"]+)"', found[name])
    return found


def _absolute(folder: str, relative: re.Match[str]) -> str:
    return f'"{posixpath.normpath(posixpath.join(folder, relative[1]))}"'
