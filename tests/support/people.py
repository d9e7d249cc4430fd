"""People in front of a camera: photographs of real faces, moved as heads move, as pictures of any camera.

The photographs are in the public domain: Eileen Collins (NASA) and Grace Hopper (U.S. Navy); neither has anything to do
with this software. A head is moved by warping the picture around it: turning in depth is not simulated.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Final, Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.source import RawVideo

Picture = NDArray[np.uint8]
Who = Literal["collins", "hopper"]

PHOTOS: Final = Path(__file__).parent / "photos"
# Where the face is in each photograph, in its pixels: middle and width.
_FACES: Final[dict[str, tuple[float, float, float]]] = {"collins": (151, 113, 96), "hopper": (133, 109, 110)}
_CHIN, _CHEST = 0.7, 1.6
"""Face widths below the middle of the face down to which all moves with the head, and from which on nothing does."""


@dataclass(frozen=True, slots=True)
class Sitter:
    """A person in the picture.

    Attributes:
        who: whose photograph.
        x, y: the middle of the face, in shares of the picture.
        size: the width of the face, in shares of the picture's width.
        turn, bow: how far the head has moved to the right and down, in face widths.
        lean: how far it leans to the right, in degrees.
    """

    who: Who
    x: float = 0.5
    y: float = 0.4
    size: float = 0.2
    turn: float = 0.0
    bow: float = 0.0
    lean: float = 0.0


Scene = Callable[[float], Sequence[Sitter]]
"""Who is in the picture at a time, in seconds."""


def picture(
    sitters: Sequence[Sitter],
    width: int = 640,
    height: int = 360,
    *,
    light: float = 1.0,
    noise: float = 2.0,
    seed: int = 0,
) -> Picture:
    """A picture of a room with people in it (height, width, 3; BGR), `light` times as bright as it was."""
    canvas = _room(width, height).copy()
    for sitter in sitters:
        _seat(canvas, sitter)
    grain = np.random.default_rng(seed).normal(0.0, noise, canvas.shape[:2])[:, :, None] if noise else 0.0
    return np.asarray(np.clip(canvas * light + grain, 0, 255), np.uint8)


def _seat(canvas: NDArray[np.float32], sitter: Sitter) -> None:
    height, width = canvas.shape[:2]
    photo, (x, y, face) = _photo(sitter.who), _FACES[sitter.who]
    pixels = sitter.size * width
    down, right = np.arange(height, dtype=np.float32)[:, None], np.arange(width, dtype=np.float32)[None]
    across, below = (right - sitter.x * width) / pixels, (down - sitter.y * height) / pixels
    # How much each place moves with the head; the neck is in between.
    moves = np.clip((_CHEST - below) / (_CHEST - _CHIN), 0.0, 1.0)
    angle = math.radians(sitter.lean) * moves
    a, b = across - sitter.turn * moves, below - sitter.bow * moves
    # The head leans over the chin.
    u = a * np.cos(angle) + (b - _CHIN) * np.sin(angle)
    v = -a * np.sin(angle) + (b - _CHIN) * np.cos(angle) + _CHIN
    columns, rows = np.asarray(x + u * face, np.float32), np.asarray(y + v * face, np.float32)
    seen = cv2.remap(photo, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    inside = np.minimum(np.minimum(columns, photo.shape[1] - columns), np.minimum(rows + 40, photo.shape[0] - rows))
    alpha = np.clip(inside / 12, 0.0, 1.0)[:, :, None]
    canvas += (seen - canvas) * alpha


@cache
def _photo(who: str) -> Picture:
    return np.asarray(cv2.imread(str(PHOTOS / f"{who}.jpg")), np.uint8)


@cache
def _room(width: int, height: int) -> NDArray[np.float32]:
    coarse = np.random.default_rng(7).integers(60, 150, (6, 9, 3)).astype(np.float32)
    return np.asarray(cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC), np.float32)


def video(scene: Scene, seconds: float, fps: float = 10.0, width: int = 640, height: int = 360) -> Iterator[RawVideo]:
    """The pictures of a scene, from 0 s on."""
    for number in range(round(seconds * fps)):
        moment = number / fps
        yield RawVideo(picture(scene(moment), width, height, seed=number), "bgr24", width, height, number, moment)


def nodding(sitter: Sitter, frequency: float = 1.5, reach: float = 0.16, begin: float = 1.0, times: int = 3) -> Scene:
    """Return a person who nods so many times, after a while."""
    return lambda moment: [replace(sitter, bow=_swing(moment - begin, frequency, reach, times))]


def shaking(sitter: Sitter, frequency: float = 1.5, reach: float = 0.16, begin: float = 1.0, times: int = 3) -> Scene:
    """Return a person who shakes the head."""
    return lambda moment: [replace(sitter, turn=_swing(moment - begin, frequency, reach, times))]


def tilting(sitter: Sitter, degrees: float = 20.0, begin: float = 1.0, end: float = 2.5) -> Scene:
    """Return a person who tilts the head, holds it, and sets it upright."""

    def lean(moment: float) -> float:
        return degrees * float(np.clip(min(moment - begin, end - moment) / 0.3, 0.0, 1.0))

    return lambda moment: [replace(sitter, lean=lean(moment))]


def _swing(moment: float, frequency: float, reach: float, times: int) -> float:
    if not 0 <= moment < times / frequency:
        return 0.0
    return reach * (1 - math.cos(2 * math.pi * frequency * moment)) / 2


def write_y4m(path: Path, scene: Scene, seconds: float, fps: int = 10, width: int = 640, height: int = 360) -> None:
    """Write a scene as Chromium's fake camera reads it: `--use-file-for-fake-video-capture=<path>`; it is looped."""
    with path.open("wb") as file:
        file.write(f"YUV4MPEG2 W{width} H{height} F{fps}:1 Ip A1:1 C420jpeg\n".encode())
        for each in video(scene, seconds, fps, width, height):
            file.write(b"FRAME\n")
            file.write(np.asarray(cv2.cvtColor(each.data, cv2.COLOR_BGR2YUV_I420), np.uint8).tobytes())
