"""How much a YAML file may hold."""

import yaml

LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""libyaml's loader where yaml was built with it, about ten times as fast."""

MAX_DEPTH = 50
MAX_NODES = 500_000
"""How deep a file may be nested, and how many values it may hold with its aliases written out."""


def check_extent(text: str) -> None:
    """Refuse what would take minutes or the whole stack to read: aliases of aliases, lists in lists.

    :raises ValueError: naming the line.
    :raises yaml.YAMLError: if it is not YAML.
    """
    sizes = [0]  # of the collections that are open
    anchors: list[str | None] = []
    anchored: dict[str | None, int] = {}
    for event in yaml.parse(text, Loader=LOADER):
        if isinstance(event, yaml.CollectionStartEvent):
            sizes.append(1)
            anchors.append(event.anchor)
            if len(anchors) > MAX_DEPTH:
                raise ValueError(f"{_line(event)}: nested more than {MAX_DEPTH} deep")
            continue
        if isinstance(event, yaml.CollectionEndEvent):
            size = sizes.pop()
            anchor = anchors.pop()
        elif isinstance(event, yaml.AliasEvent):
            if event.anchor not in anchored:
                raise ValueError(f"{_line(event)}: the alias *{event.anchor} has no anchor before it")
            size = anchored[event.anchor]
            anchor = None
        elif isinstance(event, yaml.ScalarEvent):
            size = 1
            anchor = event.anchor
        else:
            continue
        if anchor is not None:
            anchored[anchor] = size
        sizes[-1] += size
        if sizes[-1] > MAX_NODES:
            raise ValueError(f"{_line(event)}: more than {MAX_NODES} values, aliases written out")


def _line(event: yaml.Event) -> str:
    return "a line" if event.start_mark is None else f"line {event.start_mark.line + 1}"
