"""Header extensions of a sender's packets, in the one-byte form (RFC 8285 section 4.2). Pure."""

from openrois_streaming.rtp.ntp import abs_send_time, capture_time

MID = "urn:ietf:params:rtp-hdrext:sdes:mid"
"""The m-section of a packet (RFC 9143 section 15)."""

ABS_SEND_TIME = "http://www.webrtc.org/experiments/rtp-hdrext/abs-send-time"
"""Sending time of a packet, by which a receiver estimates its path."""

PLAYOUT_DELAY = "http://www.webrtc.org/experiments/rtp-hdrext/playout-delay"
"""Least and greatest playout delay of pictures in a browser: 12 bits each, in units of 10 ms."""

ABS_CAPTURE_TIME = "http://www.webrtc.org/experiments/rtp-hdrext/abs-capture-time"
"""Capture time of a packet's frame, as 64 bits of NTP."""

_AT_ONCE = bytes(3)
_AS_IT_LIKES = (1000).to_bytes(3, "big")  # 0 to 10 s


class Extensions:
    """Extension block of a sender's packets.

    With a playout delay of 0 a receiver shows each picture as soon as it is decoded, without waiting for its sound.

    Args:
        mid_id: the negotiated id of MID; None to leave it out.
        mid: the name of the m-section.
        abs_send_time_id: the negotiated id of ABS_SEND_TIME; None to leave it out.
        playout_delay_id: the negotiated id of PLAYOUT_DELAY; None to leave it out.
        capture_time_id: the negotiated id of ABS_CAPTURE_TIME; None to leave it out.
    """

    __slots__ = ("_capture", "_delays", "_others", "_prepared", "_time")

    def __init__(
        self,
        mid_id: int | None,
        mid: str,
        abs_send_time_id: int | None,
        playout_delay_id: int | None = None,
        capture_time_id: int | None = None,
    ) -> None:
        self._capture = b"" if capture_time_id is None else bytes((capture_time_id << 4 | 7,))
        self._time = b"" if abs_send_time_id is None else bytes((abs_send_time_id << 4 | 2,))
        name = mid.encode()[:16]
        element = b"" if mid_id is None or not name else bytes((mid_id << 4 | len(name) - 1,)) + name
        self._delays = (b"", b"")  # indexed by whether to play at once, as are the following
        if playout_delay_id is not None:
            header = bytes((playout_delay_id << 4 | 2,))
            self._delays = (header + _AS_IT_LIKES, header + _AT_ONCE)
        self._name(element)

    def acknowledged(self) -> None:
        """Leave MID out from now on: the receiver knows the sender by its SSRC."""
        self._name(b"")

    def block(self, moment: float, *, at_once: bool = False, captured: float | None = None) -> bytes:
        """Return the block of a packet that leaves at `moment` (epoch seconds); empty without extensions.

        It has the capture time of the frame, `captured` (epoch seconds), if that is given and negotiated.
        """
        before, after = self._prepared[at_once]
        if captured is not None and self._capture:
            element = self._capture + capture_time(captured)
            before, after = _framed(self._time, element + self._others[at_once])
        return before + abs_send_time(moment) + after if self._time else before

    def _name(self, element: bytes) -> None:
        """Prepare blocks with this MID element."""
        self._others = tuple(delay + element for delay in self._delays)
        self._prepared = tuple(_framed(self._time, others) for others in self._others)


def _framed(time_header: bytes, others: bytes) -> tuple[bytes, bytes]:
    """Return the bytes before and after the three bytes of the sending time."""
    length = (len(time_header) and 4) + len(others)
    if not length:
        return b"", b""
    words = (length + 3) // 4
    padding = bytes(words * 4 - length)
    before = b"\xbe\xde" + words.to_bytes(2, "big") + time_header
    return (before, others + padding) if time_header else (before + others + padding, b"")
