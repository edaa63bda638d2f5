"""What YAML holds."""

from typing import Any

import yaml

QUICK = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""libyaml's, some ten times as quick; a yaml that was built without it has none."""


def read_yaml(text: str) -> Any:
    """What the text holds. What is amiss is left to yaml's own reader to tell, for that shows the line.

    :raises yaml.YAMLError: if it is not YAML.
    """
    try:
        return yaml.load(text, Loader=QUICK)
    except yaml.YAMLError:
        return yaml.safe_load(text)
