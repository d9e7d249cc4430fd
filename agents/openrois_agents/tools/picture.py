"""A picture for a language model: of a body's camera, a second old at most, of a bounded size."""

import asyncio
import time
from dataclasses import dataclass
from typing import Any, Final

from openrois.client import ComponentFailed, OutOfResources
from openrois.extras import needing_extra
from openrois_agents.tools.gateway_link import GatewayLink

__all__ = ["MAX_BYTES", "Picture", "take_picture"]

MAX_BYTES: Final = 256_000
"""Bytes of a picture as JPEG."""

_QUALITIES: Final = (85, 70, 50, 30)
_TIMEOUT: Final = 15.0


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture.

    Attributes:
        file: as JPEG.
        width, height: in pixels.
        age: seconds since it was captured, without the way of a packet; None where the body does not tell its clock.
    """

    file: bytes
    width: int
    height: int
    age: float | None


async def take_picture(link: GatewayLink, camera: str, width: int) -> Picture:
    """Return a picture.

    Args:
        link: to the gateway.
        camera: a component with a stream of pictures.
        width: of the longer side at most, in pixels.

    Raises:
        MissingExtra: the libraries for media are not installed.
        RoISError: the engine refuses, or no picture comes.
    """
    media = await link.media()
    try:
        frame = await media.new_frame(camera, "bgr24", timeout=_TIMEOUT)
    except TimeoutError as error:
        raise ComponentFailed(str(error)) from error
    age = None if frame.captured_at is None else time.monotonic() - frame.local_time
    return Picture(*await asyncio.to_thread(_encoded, frame.data, width), age)


def _encoded(pixels: Any, longest: int) -> tuple[bytes, int, int]:
    """Make a picture as small as it has to be, and a JPEG file of it."""
    with needing_extra("streaming"):
        import cv2
    height, width = pixels.shape[:2]
    share = min(1.0, longest / max(height, width))
    size = (max(1, round(width * share)), max(1, round(height * share)))
    if share < 1:
        pixels = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    for quality in _QUALITIES:
        done, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])
        if done and len(data) <= MAX_BYTES:
            return data.tobytes(), *size
    raise OutOfResources(f"the picture has more than {MAX_BYTES} bytes: ask for a smaller width")
