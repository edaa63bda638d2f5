"""What packets bring beside their effects: images and readings, as they travel in a robot's report."""

from base64 import b64decode, b64encode
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, PlainSerializer, model_validator
from typing_extensions import Self

from robots.wire.script import Wire

MAX_IMAGE_BYTES = 512 * 1024
"""The largest image that a report carries: it must fit into one message of any link (our choice)."""
SIGNATURES = {"image/png": b"\x89PNG\r\n\x1a\n", "image/jpeg": b"\xff\xd8\xff"}
"""Media types of images, and the bytes that each begins with."""


def _decoded(value: object) -> object:
    return b64decode(value, validate=True) if isinstance(value, str) else value


Base64 = Annotated[
    bytes,
    BeforeValidator(_decoded, json_schema_input_type=str),
    PlainSerializer(lambda data: b64encode(data).decode(), return_type=str, when_used="json"),
]
"""Bytes, as base64 in JSON."""


class ImageResult(Wire):
    """An image that a robot's camera `name` has taken of a place, a sample or a robot."""

    kind: Literal["image"] = "image"
    name: str = Field(min_length=1, max_length=64)
    of: str = Field(min_length=1, max_length=64)
    media_type: Literal["image/png", "image/jpeg"]
    data: Base64 = Field(max_length=MAX_IMAGE_BYTES)

    @model_validator(mode="after")
    def _is_what_it_says(self) -> Self:
        if not self.data.startswith(SIGNATURES[self.media_type]):
            raise ValueError(f"data: its first bytes are not those of {self.media_type}")
        return self


class ReadingResult(Wire):
    """What a robot has read of the quantity `name` at a place, a sample or a robot."""

    kind: Literal["reading"] = "reading"
    name: str = Field(min_length=1, max_length=64)
    of: str = Field(min_length=1, max_length=64)
    value: float = Field(allow_inf_nan=False)
    unit: str = Field(default="", max_length=16)


PacketResult = Annotated[ImageResult | ReadingResult, Field(discriminator="kind")]
