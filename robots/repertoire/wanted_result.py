"""The results that a packet brings beside its effects, as its file names them."""

from pydantic import Field, model_validator
from typing_extensions import Self

from robots.data import Checked


class WantedResult(Checked):
    """The image of a camera, or the reading of a quantity in `unit`, of a place, a sample or a robot."""

    image: str | None = Field(default=None, min_length=1, max_length=64)
    reading: str | None = Field(default=None, min_length=1, max_length=64)
    unit: str = Field(default="", max_length=16)
    of: str = Field(min_length=1, max_length=64)

    @model_validator(mode="after")
    def _is_one_of_both(self) -> Self:
        if (self.image is None) == (self.reading is None):
            raise ValueError("a result is either an image (of which camera) or a reading (of which quantity)")
        if self.image is not None and self.unit:
            raise ValueError("unit: an image has none")
        return self

    @property
    def quantity(self) -> str:
        """What is read; empty for an image."""
        return self.reading or ""
