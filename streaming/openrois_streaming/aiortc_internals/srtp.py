"""SRTP protection by libsrtp itself: pylibsrtp allocates and checks for each packet, which takes as long as the cipher.

Private names in use: `pylibsrtp.Session._srtp`, the session of the C library, and the functions of its binding.
"""

from collections.abc import Callable, Sequence
from typing import Any

import pylibsrtp
from pylibsrtp import Policy, Session
from pylibsrtp._binding import ffi, lib

PACKET_LIMIT = 1500
"""Limit on the bytes of a packet to be protected."""

_TRAILER = 4 + 16 + 128  # SRTCP's index, tag and key identifier at their longest (srtp.h)


class Protection:
    """Encryption and authentication of outgoing packets, with the keys of `session`."""

    __slots__ = ("_buffer", "_length", "_session", "_view")

    def __init__(self, session: Any) -> None:
        self._session = session
        self._buffer = ffi.new("char[]", PACKET_LIMIT + _TRAILER)
        self._view = ffi.buffer(self._buffer)
        self._length = ffi.new("int *")

    def rtp(self, packets: Sequence[bytes]) -> list[bytes]:
        """Protect RTP packets (RFC 3711 section 3.1).

        Raises:
            pylibsrtp.Error: a packet cannot be protected.
        """
        return self._protected(packets, lib.srtp_protect)

    def rtcp(self, packet: bytes) -> bytes:
        """Protect a compound RTCP packet (RFC 3711 section 3.4).

        Raises:
            pylibsrtp.Error: the packet cannot be protected.
        """
        return self._protected([packet], lib.srtp_protect_rtcp)[0]

    def _protected(self, packets: Sequence[bytes], function: Callable[..., int]) -> list[bytes]:
        buffer, view, length, context = self._buffer, self._view, self._length, self._session._srtp[0]
        protected: list[bytes] = []
        for packet in packets:
            octets = len(packet)
            if octets > PACKET_LIMIT:
                raise pylibsrtp.Error(f"a packet of {octets} bytes exceeds the limit of {PACKET_LIMIT}")
            length[0] = octets
            view[0:octets] = packet
            if code := function(context, buffer, length):
                raise pylibsrtp.Error(f"libsrtp's error {code}")
            protected.append(view[0 : length[0]])
        return protected


def differences() -> list[str]:
    """Return the differences from what this module relies on."""
    policy = Policy(key=bytes(range(30)), ssrc_type=Policy.SSRC_ANY_OUTBOUND)
    packet = bytes.fromhex("80610001000000020000000a") + b"payload"
    report = bytes.fromhex("80c90001000000010000000a")
    theirs, ours = Session(policy), Protection(Session(policy))
    same = ours.rtp([packet]) == [theirs.protect(packet)] and ours.rtcp(report) == theirs.protect_rtcp(report)
    return [] if same else ["packets are protected otherwise"]
