"""Checks frames of clients for violations of RFC 6455 that the server library lets pass; bounds small frames. Pure."""

from dataclasses import dataclass
from typing import Final

from openrois.aio.rate import RateLimit

__all__ = [
    "BROKEN",
    "CONTROL_FRAMES_AT_ONCE",
    "CONTROL_FRAMES_PER_SECOND",
    "MAX_FRAGMENTS",
    "Fault",
    "FrameRules",
]

MAX_FRAGMENTS: Final = 1024
"""Frames of one message; it has 64 KiB or 1 MiB at most, so that a well-behaved client needs no more."""

CONTROL_FRAMES_AT_ONCE: Final = 1000
"""Pings and pongs of one connection in a burst."""

CONTROL_FRAMES_PER_SECOND: Final = 100
"""Pings and pongs of one connection in the long run."""

BROKEN: Final = b"broken"
"""Text of the pong that is sent in place of a frame that broke the rules, behind all that came before it."""

_BROKEN_FRAME: Final = bytes((0x8A, len(BROKEN))) + BROKEN
_WRONG: Final = -1
_NOT_WHOLE: Final = 0
_PROTOCOL_ERROR: Final = 1002
_TOO_MUCH: Final = 1008
_CLOSE: Final = 8
_MAY_BE_SENT: Final = frozenset((*range(1000, 1004), *range(1007, 1015), *range(3000, 5000)))
"""Codes of a close frame (RFC 6455, 7.4, and the registry of IANA)."""


@dataclass(frozen=True, slots=True)
class Fault:
    """Violation for which a connection has to end.

    Attributes:
        code: with which close code.
        reason: what was wrong.
    """

    code: int
    reason: str


class FrameRules:
    """Checks what a client sends, frame by frame.

    What the server library refuses by itself is left to it: reserved bits and opcodes, control frames that are long or
    in fragments, text that is no UTF-8, messages that are too long.

    Args:
        control: how often there may be a ping or pong.

    Attributes:
        fault: what was wrong; nothing passes any more then.
    """

    def __init__(self, control: RateLimit) -> None:
        self.fault: Fault | None = None
        self._control = control
        self._payload = 0
        """Bytes that are still to come of the frame that is under way."""
        self._head = b""
        """Bytes of an incomplete header."""
        self._frames = 0
        """Frames that have come of the message that is under way; 0 where there is none."""

    def passed(self, data: bytes) -> bytes:
        """Return what may be parsed: whole headers and the payloads received, up to the first fault and a mark."""
        if self.fault is not None:
            return b""
        if self._head:
            data = self._head + data
            self._head = b""
        end = len(data)
        at = self._payload
        while at < end:
            following = self._next(data, at, end)
            if following == _WRONG:
                return data[:at] + _BROKEN_FRAME
            if following == _NOT_WHOLE:
                self._payload = 0
                self._head = data[at:]
                return data[:at]
            at = following
        self._payload = at - end
        return data

    def _next(self, data: bytes, at: int, end: int) -> int:
        """Judge the frame at `at`; return where the next one begins, unless it is wrong or incomplete."""
        if end - at < 2:
            return _NOT_WHOLE
        second = data[at + 1]
        if second < 0x80:
            return self._wrong("frames of a client must be masked")
        length = second & 0x7F
        body = at + 6
        if length > 125:
            size = 2 if length == 126 else 8
            body += size
            if end < body:
                return _NOT_WHOLE
            length = int.from_bytes(data[at + 2 : at + 2 + size], "big")
            if length < (126 if size == 2 else 1 << 16) or length >> 63:
                return self._wrong("a length must have its shortest form")
        if end < body:
            return _NOT_WHOLE
        return self._judge(data, at, body, length)

    def _judge(self, data: bytes, at: int, body: int, length: int) -> int:
        opcode = data[at] & 0x0F
        if opcode < _CLOSE:
            return self._part(opcode, is_last=data[at] >= 0x80) or body + length
        if opcode > _CLOSE:
            return body + length if self._control.admits() else self._wrong("too many pings or pongs", _TOO_MUCH)
        if length < 2:
            return body + length
        if len(data) < body + 2:
            return _NOT_WHOLE
        code = (data[body] ^ data[body - 4]) << 8 | (data[body + 1] ^ data[body - 3])
        return body + length if code in _MAY_BE_SENT else self._wrong(f"code {code} may not be sent")

    def _part(self, opcode: int, *, is_last: bool) -> int:
        """Count a part of a message; return 0, or that it is wrong."""
        if (opcode == 0) != (self._frames > 0):
            return self._wrong("a message must end before the next begins" if opcode else "nothing is continued")
        self._frames = 0 if is_last else self._frames + 1
        if self._frames >= MAX_FRAGMENTS:
            return self._wrong(f"a message may have {MAX_FRAGMENTS} fragments at most", _TOO_MUCH)
        return 0

    def _wrong(self, reason: str, code: int = _PROTOCOL_ERROR) -> int:
        self.fault = Fault(code, reason)
        return _WRONG
