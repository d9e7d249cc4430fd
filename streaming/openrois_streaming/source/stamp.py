"""Frame number and capture time in the picture itself, readable behind any codec and any network.

The stamp is a row of 80 cells along the bottom. A cell is one bit, the first one on the left: black (luma 16, RGB 0) is
0, white (luma 235, RGB 255) is 1.

- 4 bits: 1, 0, 1, 0
- 24 bits: frame number modulo 2**24, most significant bit first
- 44 bits: wall time in units of 0.1 ms since the epoch, modulo 2**44, most significant bit first
- 8 bits: CRC-8 (polynomial 0x07, start value 0, not reflected, no final xor) of number and time, these 68 bits taken as
  nine bytes: `(number << 44 | time).to_bytes(9, "big")`

In a picture of W x H pixels, cell c covers the columns from c * W // 80 up to (c + 1) * W // 80, of the last
max(8, H * 8 // 360) rows. A reader takes the mean luma of the middle half of a cell in both directions: what is left
without a quarter, rounded down, of its columns and of its rows on either side. 128 and above is 1. A picture that was
scaled down to less than 360 rows has its stamp in the last H * 8 // 360 rows, so a reader tries these too.

`tests/streaming/source/stamp_vectors.json` holds examples for readers in other languages.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from openrois_streaming.source.source import RawVideo

CELLS: Final = 80
MIN_WIDTH: Final = 2 * CELLS
MIN_HEIGHT: Final = 16
"""Pixels; a smaller picture carries no stamp."""

NUMBER_MODULUS: Final = 1 << 24
TIME_MODULUS: Final = 1 << 44
TIME_UNITS_PER_SECOND: Final = 10_000

_SYNC = 0b1010
_LUMA = np.array([16, 235], np.uint8)
_RGB = np.array([0, 255], np.uint8)
_GREY = 128


@dataclass(frozen=True, slots=True)
class Stamp:
    """Stamp of a picture: its `number`, and its capture `time` in 0.1 ms, both by their moduli."""

    number: int
    time: int

    @classmethod
    def at(cls, number: int, wall: float) -> Self:
        """Return the stamp of picture `number` (any integer >= 0) captured at `wall` (epoch seconds)."""
        return cls(number % NUMBER_MODULUS, round(wall * TIME_UNITS_PER_SECOND) % TIME_MODULUS)

    def age(self, wall: float) -> float:
        """Return the seconds from the capture to `wall` (epoch seconds), exact to 0.1 ms; negative if it is later."""
        behind = (round(wall * TIME_UNITS_PER_SECOND) - self.time) % TIME_MODULUS
        if behind >= TIME_MODULUS // 2:
            behind -= TIME_MODULUS
        return behind / TIME_UNITS_PER_SECOND

    def bits(self) -> NDArray[np.uint8]:
        """Return the 80 cells from left to right, each 0 or 1."""
        body = self.number << 44 | self.time
        return np.unpackbits(np.frombuffer((_SYNC << 76 | body << 8 | _crc8(body)).to_bytes(10, "big"), np.uint8))

    @classmethod
    def from_bits(cls, bits: NDArray[np.uint8] | NDArray[np.bool_]) -> Self | None:
        """Return the stamp of 80 cells; None if they are not a stamp."""
        value = int.from_bytes(np.packbits(bits).tobytes(), "big")
        body = value >> 8 & (1 << 68) - 1
        if value >> 76 != _SYNC or value & 0xFF != _crc8(body):
            return None
        return cls(body >> 44, body & TIME_MODULUS - 1)


def write(pixels: NDArray[np.uint8], number: int, wall: float) -> None:
    """Write a stamp into a picture, in place.

    Args:
        pixels: uint8 of shape (height, width, 3 or 4) in RGB or BGR order (alpha is left alone), or (height, width):
            a luma plane. At least MIN_WIDTH x MIN_HEIGHT.
        number: of the picture.
        wall: the time of day that the picture shows, epoch seconds.

    Raises:
        ValueError: the picture is too small, or read-only.
    """
    height, width = pixels.shape[:2]
    if width < MIN_WIDTH or height < MIN_HEIGHT:
        raise ValueError(f"a {width}x{height} picture is too small for a stamp, which needs {MIN_WIDTH}x{MIN_HEIGHT}")
    row = Stamp.at(number, wall).bits()[_geometry(width).cell_of_column]
    if pixels.ndim == 2:
        pixels[-stamp_rows(height) :] = _LUMA[row]
    else:
        pixels[-stamp_rows(height) :, :, :3] = _RGB[row][:, np.newaxis]


def read(luma: NDArray[np.uint8]) -> Stamp | None:
    """Return the stamp in a luma plane, uint8 of shape (height, width); None if there is none.

    A picture without a stamp is taken for one with it in about one of 4000 cases, if its last rows are noise.
    """
    height, width = luma.shape
    if width < MIN_WIDTH or height < MIN_HEIGHT:
        return None
    scaled_rows = height * 8 // 360
    for rows in (stamp_rows(height), scaled_rows) if 2 <= scaled_rows < stamp_rows(height) else (stamp_rows(height),):
        stamp = _read_rows(luma, rows)
        if stamp is not None:
            return stamp
    return None


def stamped(raw: RawVideo, wall: float) -> RawVideo:
    """Return the picture with a stamp of its sequence number and of `wall` (epoch seconds).

    It is written into the frame's own pixels where they can be written to, otherwise into a copy. A picture that is too
    small for a stamp stays as it is.
    """
    if raw.width < MIN_WIDTH or raw.height < MIN_HEIGHT:
        return raw
    data = raw.data
    if raw.format == "i420":
        data = data if data.flags.writeable and data.flags.c_contiguous else np.ascontiguousarray(data).copy()
        write(data[: raw.height], raw.sequence, wall)
        _neutralise_colour(data, raw.width, raw.height)
    elif raw.format == "nv12":
        data = data if data.flags.writeable else data.copy()
        write(data[: raw.height], raw.sequence, wall)
        data[raw.height + (raw.height - stamp_rows(raw.height)) // 2 :] = _GREY
    else:
        data = data if data.flags.writeable else data.copy()
        write(data, raw.sequence, wall)
    return raw if data is raw.data else replace(raw, data=data)


def _neutralise_colour(data: NDArray[np.uint8], width: int, height: int) -> None:
    """Make the stamp of a contiguous I420 picture black and white also for a reader that sees RGB."""
    first = (height - stamp_rows(height)) // 2
    planes = data.reshape(-1)[width * height :].reshape(2, height // 2, width // 2)
    planes[:, first:] = _GREY


class _Geometry(NamedTuple):
    cell_of_column: NDArray[np.intp]
    left: NDArray[np.intp]
    """First column of the middle half of each cell."""
    right: NDArray[np.intp]
    """First column after it."""


@lru_cache(maxsize=32)
def _geometry(width: int) -> _Geometry:
    edges = np.arange(CELLS + 1) * width // CELLS
    widths = np.diff(edges)
    margins = widths // 4
    return _Geometry(np.repeat(np.arange(CELLS), widths), edges[:-1] + margins, edges[1:] - margins)


def stamp_rows(height: int) -> int:
    """Return how many rows at the bottom of a picture of `height` rows its stamp takes."""
    return max(8, height * 8 // 360)


def _read_rows(luma: NDArray[np.uint8], rows: int) -> Stamp | None:
    height, width = luma.shape
    band = luma[height - rows + rows // 4 : height - rows // 4]
    sums = np.concatenate(([0], np.cumsum(band.sum(axis=0, dtype=np.int64))))
    geometry = _geometry(width)
    means = (sums[geometry.right] - sums[geometry.left]) / ((geometry.right - geometry.left) * len(band))
    return Stamp.from_bits(means >= _GREY)


def _crc8(body: int) -> int:
    crc = 0
    for byte in body.to_bytes(9, "big"):
        crc = _CRC8[crc ^ byte]
    return crc


def _crc8_of_byte(byte: int) -> int:
    for _ in range(8):
        byte = (byte << 1 ^ 0x07 if byte & 0x80 else byte << 1) & 0xFF
    return byte


_CRC8 = bytes(map(_crc8_of_byte, range(256)))
