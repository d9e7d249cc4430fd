"""The option `--size`: width and height of the pictures of an embedded game engine."""

import argparse
import re
from typing import Final

__all__ = ["AUTOMATIC", "SIZE_HELP", "PictureSize", "picture_size", "size_text"]

PictureSize = tuple[int, int] | None
"""Width and height in pixels; None: the engine chooses."""
AUTOMATIC: Final = "auto"
_LEAST: Final = (160, 90)
_MOST: Final = (1920, 1080)
SIZE_HELP: Final = "of the pictures, in pixels; auto: 1280x720 where the machine carries it, else 640x360 (%(default)s)"


def picture_size(text: str) -> PictureSize:
    """Read the value of `--size`.

    Raises:
        argparse.ArgumentTypeError: the text is no size that can be drawn and encoded.
    """
    if text == AUTOMATIC:
        return None
    found = re.fullmatch(r"([0-9]{1,5})x([0-9]{1,5})", text)
    if found is None:
        raise argparse.ArgumentTypeError(f"{text!r} is no size: write WIDTHxHEIGHT, as 1280x720, or {AUTOMATIC}")
    width, height = int(found[1]), int(found[2])
    if width % 2 or height % 2:
        even = f"{width - width % 2}x{height - height % 2}"
        raise argparse.ArgumentTypeError(f"{text}: width and height must be even numbers, as {even}")
    if not (_LEAST[0] <= width <= _MOST[0] and _LEAST[1] <= height <= _MOST[1]):
        bounds = " to ".join(size_text(size) for size in (_LEAST, _MOST))
        raise argparse.ArgumentTypeError(f"{text} is out of bounds: choose a size from {bounds}")
    return width, height


def size_text(size: PictureSize) -> str:
    """Return a size as a value of `--size`."""
    return AUTOMATIC if size is None else f"{size[0]}x{size[1]}"
