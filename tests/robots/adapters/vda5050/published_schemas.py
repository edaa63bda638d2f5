"""The JSON schemas that the VDA publishes: of 2.1 from a package; of 3.0 from a folder that VDA5050_SCHEMAS names.

No package ships those of 3.0.
"""

import json
import os
import re
from collections.abc import Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import jsonschema

from robots.adapters.vda5050.topics import Topic

FOLDER = os.environ.get("VDA5050_SCHEMAS")
"""Where `order.schema`, `state.schema` and so on of 3.0 are; None: 3.0 is checked by our own types alone."""
MAJORS = (2,) if FOLDER is None else (2, 3)


@cache
def _validators(major: int) -> Mapping[Topic, jsonschema.Draft202012Validator]:
    return {topic: jsonschema.Draft202012Validator(_schema(major, topic)) for topic in Topic}


def _schema(major: int, topic: Topic) -> Any:
    if major == 2:
        folder = resources.files("vda5050") / "validation" / "schemas"
        return json.loads((folder / f"{topic}.json").read_text(encoding="utf-8"))
    text = (Path(str(FOLDER)) / f"{topic}.schema").read_text(encoding="utf-8")
    # NOTE: the files of 3.0.0 have commas before closing brackets, which is not JSON.
    return json.loads(re.sub(r",(\s*[}\]])", r"\1", text))


def faults(major: int, topic: Topic, payload: bytes) -> list[str]:
    """What the published schema has against a message."""
    found = _validators(major)[topic].iter_errors(json.loads(payload))
    return [f"{topic} {'.'.join(map(str, one.absolute_path))}: {one.message}" for one in found]
