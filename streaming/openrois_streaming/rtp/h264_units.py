"""Check of an H.264 access unit before it is passed on: its NAL units, profile and size. Pure.

Numbers of sections and tables are those of ITU-T H.264. Hardware decoders of viewers rely on these checks.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

MAX_UNITS: Final = 1_000
"""Limit on the NAL units of an access unit."""
_START_CODE: Final = b"\0\0\1"
_SLICE, _IDR, _SEI, _SPS, _PPS, _DELIMITER, _FILLER = 1, 5, 6, 7, 8, 9, 12
_KNOWN: Final = frozenset({_SLICE, _IDR, _SEI, _SPS, _PPS, _DELIMITER, _FILLER})
_BASELINE: Final = 66
_CONSTRAINED: Final = 0x40  # constraint_set1_flag (section 7.4.2.1.1)
_HIGHEST_LEVEL: Final = 62
_MOST_ONES: Final = 16  # zero bits that lead an Exp-Golomb code of what is read here
_MOST_MACROBLOCKS: Final = 1_024  # of a side: 16,384 pixels
_CROP: Final = 2  # pixels of a unit of the crop rectangle in 4:2:0


class NotPassable(ValueError):
    """Access unit that cannot be passed on; the text says why."""


@dataclass(frozen=True, slots=True)
class AccessUnit:
    """Checked access unit: `keyframe` is whether it can be decoded by itself, `size` its width and height if given."""

    keyframe: bool
    size: tuple[int, int] | None


def access_unit(data: bytes | bytearray | memoryview) -> AccessUnit:
    """Check an access unit in Annex B form: one picture in constrained baseline, as WebRTC endpoints decode it.

    Raises:
        NotPassable: it is malformed, of another profile, or an IDR picture without its parameter sets.
    """
    kinds: list[int] = []
    size: tuple[int, int] | None = None
    for unit in _units(bytes(data)):
        kind = unit[0] & 0x1F
        if unit[0] & 0x80 or kind not in _KNOWN:
            raise NotPassable(f"a NAL unit of type {kind} is not allowed in constrained baseline")
        if kind == _SPS:
            size = _size(unit)
        kinds.append(kind)
    pictures = {kind for kind in kinds if kind in (_SLICE, _IDR)}
    if not pictures:
        raise NotPassable("it has no picture: send each with its slices")
    if len(pictures) > 1:
        raise NotPassable("an IDR picture also has non-IDR slices: send them apart")
    keyframe = _IDR in pictures
    if keyframe:
        before = set(kinds[: kinds.index(_IDR)])
        if not {_SPS, _PPS} <= before:
            raise NotPassable("an IDR picture needs its SPS and PPS before it, in the same access unit")
    return AccessUnit(keyframe, size)


def _units(data: bytes) -> Iterator[bytes]:
    """Yield the NAL units between start codes (annex B)."""
    start = data.find(_START_CODE)
    if start < 0 or data[:start].strip(b"\0"):
        raise NotPassable("it does not begin with a start code: Annex B is expected")
    for _ in range(MAX_UNITS):
        end = data.find(_START_CODE, start + 3)
        unit = data[start + 3 : end if end >= 0 else None].rstrip(b"\0")
        if not unit:
            raise NotPassable("a NAL unit is empty")
        yield unit
        if end < 0:
            return
        start = end
    raise NotPassable(f"it has more than {MAX_UNITS} NAL units")


def _size(unit: bytes) -> tuple[int, int]:
    """Return width and height of a sequence parameter set (section 7.3.2.1.1) of constrained baseline."""
    if len(unit) < 4:
        raise NotPassable("the SPS is too short")
    profile, constraints, level = unit[1:4]
    if profile != _BASELINE or not constraints & _CONSTRAINED:
        raise NotPassable(f"profile {profile} with constraints {constraints:#04x}: constrained baseline is expected")
    if not 10 <= level <= _HIGHEST_LEVEL:
        raise NotPassable(f"level {level} is not known")
    bits = _Bits(unit[4:].replace(b"\0\0\3", b"\0\0"))
    bits.number()  # seq_parameter_set_id
    bits.number()  # log2_max_frame_num_minus4
    _skip_order_count(bits)
    bits.number()  # max_num_ref_frames
    bits.one()  # gaps_in_frame_num_value_allowed_flag
    width, height = 16 * _macroblocks(bits), 16 * _macroblocks(bits)
    if not bits.one():  # frame_mbs_only_flag
        raise NotPassable("interlaced pictures cannot be passed on")
    bits.one()  # direct_8x8_inference_flag
    if bits.one():  # frame_cropping_flag
        left, right, top, bottom = (_CROP * bits.number() for _ in range(4))
        width, height = width - left - right, height - top - bottom
    if width < 2 or height < 2:
        raise NotPassable("the SPS crops all of the picture")
    return width, height


def _macroblocks(bits: "_Bits") -> int:
    count = bits.number() + 1
    if count > _MOST_MACROBLOCKS:
        raise NotPassable("the SPS says that the picture is larger than 16,384 pixels")
    return count


def _skip_order_count(bits: "_Bits") -> None:
    """Skip all fields of pic_order_cnt_type."""
    kind = bits.number()
    if kind == 0:
        bits.number()
    elif kind == 1:
        bits.one()
        bits.number()  # signed ones have as many bits
        bits.number()
        for _ in range(bits.number()):
            bits.number()


class _Bits:
    """Reader of flags and Exp-Golomb codes (section 9.1) from the first bit on."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._position = 0

    def one(self) -> int:
        """Read the next bit."""
        byte, bit = divmod(self._position, 8)
        if byte >= len(self._data):
            raise NotPassable("the SPS is too short")
        self._position += 1
        return self._data[byte] >> (7 - bit) & 1

    def number(self) -> int:
        """Read the next ue(v), up to 17 bits."""
        zeros = 0
        while not self.one():
            zeros += 1
            if zeros > _MOST_ONES:
                raise NotPassable("a number in the SPS is too large")
        value = 1
        for _ in range(zeros):
            value = value << 1 | self.one()
        return value - 1
