"""Takes a packet's results from what is perceived when it ends."""

from pydantic import ValidationError

from robots.errors import ResultError
from robots.perception.percepts import Percepts
from robots.physical.body import Image
from robots.repertoire.wanted_result import WantedResult
from robots.wire import MAX_IMAGE_BYTES, ImageResult, PacketResult, ReadingResult


def taken(wanted: WantedResult, percepts: Percepts) -> PacketResult:
    """The result, for the robot's report.

    :raises ResultError: if the quantity is not measured, or the image cannot be sent.
    """
    if wanted.image is not None:
        return _image(wanted.image, wanted.of, percepts.data.get(wanted.image))
    value = percepts.measured.get(wanted.quantity)
    if value is None:
        measured = ", ".join(sorted(percepts.measured)) or "nothing"
        raise ResultError(f"{percepts.me} does not measure {wanted.quantity}; it measures {measured}")
    return ReadingResult(name=wanted.quantity, of=wanted.of, value=value, unit=wanted.unit)


def _image(camera: str, of: str, image: Image) -> ImageResult:
    if len(image.data) > MAX_IMAGE_BYTES:
        raise ResultError(
            f"the image of {camera} has {len(image.data):,} bytes, at most {MAX_IMAGE_BYTES:,} can be sent: take "
            "a smaller one, or compress it more"
        )
    try:
        return ImageResult.model_validate(
            {"name": camera, "of": of, "media_type": image.media_type, "data": image.data}
        )
    except ValidationError as error:
        faults = "; ".join(
            f"{one['loc'][0] if one['loc'] else 'data'}: {one['msg']}" for one in error.errors()
        )
        raise ResultError(f"the image of {camera} cannot be sent: {faults}") from None
