"""Engines that a default install is without: the extra `engines` installs them."""

from collections.abc import Iterable

EXTRA = "engines"


def not_installed(engines: Iterable[str]) -> str:
    """That these are missing, and how to get them."""
    return (
        f"not installed: {', '.join(engines)}; "
        f"install macta[{EXTRA}], in a checkout by `uv sync --extra {EXTRA}`"
    )
