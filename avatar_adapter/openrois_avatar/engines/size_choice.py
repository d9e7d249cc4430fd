"""The choice of the picture size: large pictures where drawing and encoding them leaves the machine enough time."""

import time
from collections.abc import Callable, Sequence
from statistics import median
from typing import Final

from openrois_streaming.publish.encoder import Chunk
from openrois_streaming.publish.video_encoder import VideoEncoder
from openrois_streaming.source.source import RawVideo

from openrois_avatar.engines.animation.animator import Animator
from openrois_avatar.engines.animation.visemes import Track
from openrois_avatar.engines.settings import LARGE, SMALL, Picture, Pixels, Renderer
from openrois_avatar.options.picture_size import size_text

PICTURES: Final = 12
"""Pictures that are drawn and encoded for the choice; the first ones warm up and do not count."""
LONGEST: Final = 1.0
"""Seconds after which no further picture is drawn for the choice."""
SHARE: Final = 1 / 3
"""Share of the time between two pictures that one may take, in processor time, drawing and encoding together."""
_WARMING: Final = 2
_BITRATE: Final = 2_500_000
_SHAPES: Final = ("aa", "PP", "oh", "E", "FF", "sil")

Clock = Callable[[], float]


def choose_size(
    renderer: Renderer,
    fps: int,
    encode: Callable[[Pixels, int], object],
    spent: Clock = time.process_time,
    now: Clock = time.monotonic,
) -> tuple[Picture, str]:
    """Return the size that this machine carries, and a sentence with the figure that decided.

    Processor time is what counts: other programs that are busy for a moment change nothing. A machine that does not
    get through the first pictures within `LONGEST` gets the small size.

    Args:
        renderer: draws pictures of the size `LARGE`.
        fps: pictures a second that are asked for.
        encode: converts and encodes one of them, with its number.
        spent: processor time of this process, in seconds.
        now: the time, in seconds.
    """
    costs = _costs(renderer, fps, encode, spent, now)
    allowed = SHARE / fps
    if not costs:
        told, carried = f"not even {_WARMING + 1} pictures of {size_text(LARGE)} in {LONGEST:g} s", False
    else:
        cost = median(costs)
        carried = cost <= allowed
        told = f"a picture of {size_text(LARGE)} takes {cost * 1e3:.1f} ms to draw and encode"
    width, height = LARGE if carried else SMALL
    return Picture(width, height, fps), f"pictures of {width}x{height}: {told}; {allowed * 1e3:.1f} ms are allowed"


def _costs(
    renderer: Renderer, fps: int, encode: Callable[[Pixels, int], object], spent: Clock, now: Clock
) -> list[float]:
    """Return the seconds for each picture of a talking figure, except for the first ones."""
    animator, costs, end = Animator(), list[float](), now() + LONGEST
    animator.speak(0.0, Track(0.0, [(n * 0.12, shape, 1.0) for n, shape in enumerate(_SHAPES)], 10.0))
    for number in range(PICTURES):
        begun = spent()
        encode(renderer.draw(animator.pose(number / fps)), number)
        costs.append(spent() - begun)
        if now() >= end:
            break
    return costs[_WARMING:]


def encoding(fps: int, convert: Callable[[Pixels], Pixels]) -> Callable[[Pixels, int], Sequence[Chunk]]:
    """Return a function that encodes large pictures as the adapter does.

    Args:
        fps: pictures a second.
        convert: makes the planes Y, U, V of a picture.
    """
    encoder = VideoEncoder("video/H264", bitrate=_BITRATE, frame_rate=fps, size=LARGE)

    def encode(pixels: Pixels, number: int) -> Sequence[Chunk]:
        width, height = LARGE
        raw = RawVideo(convert(pixels), "i420", width, height, number, number / fps)
        return encoder.encode(raw, key_frame=number == 0)

    return encode
