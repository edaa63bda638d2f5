"""`macta world generate`: a sample store of any size, as a world file."""

import sys
from collections.abc import Mapping
from pathlib import Path

from app.domain.errors import Invalid
from robots.world import StoreShapeError, generate_world, store_shape, world_yaml


def generate(
    samples: int, compartments: int, others: Mapping[str, int | None], seed: int, out: Path | None
) -> None:
    """Write the world file; the same text for the same numbers and seed.

    :raises Invalid: if no store of these numbers can be built, or the file cannot be written.
    """
    try:
        text = world_yaml(
            generate_world(store_shape(samples=samples, compartments=compartments, **others), seed=seed)
        )
    except StoreShapeError as error:
        raise Invalid(f"no such store can be built: {error}") from error
    if out is None:
        sys.stdout.write(text)
        return
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise Invalid(f"--out: {out} cannot be written: {error.strerror}") from error
