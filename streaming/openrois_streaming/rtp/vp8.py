"""VP8 in RTP (RFC 7741): a frame is cut into pieces, each with the shortest payload descriptor. Pure."""

_START = b"\x10"  # S: the first piece of the first partition (section 4.2)
_FURTHER = b"\x00"


def vp8_payloads(frame: bytes, limit: int) -> tuple[bytes, ...]:
    """The RTP payloads of a frame, all but the last `limit` bytes long.

    They carry no picture id: a viewer that is left out of some pictures, or moved to another encoding, sees sequence
    numbers without gaps, and a picture id would tell it of a loss.
    """
    step = limit - 1
    return tuple(
        (_FURTHER if position else _START) + frame[position : position + step]
        for position in range(0, len(frame), step)
    )
