"""RTCP packets that a receiver sends (RFC 3550 section 6.4.2, RFC 4585 section 6, draft-alvestrand-rmcat-remb).

Pure.
"""

import struct
from collections.abc import Iterable

from openrois_streaming.receive.reception import Reception

_RECEIVER_REPORT, _TRANSPORT_FEEDBACK, _PAYLOAD_FEEDBACK = 201, 205, 206
_NACK, _PLI, _APPLICATION = 1, 1, 15


def receiver_report(ssrc: int, source: int, reception: Reception) -> bytes:
    """Return a report of `ssrc` on what it has received of `source`."""
    lost = (reception.fraction_lost << 24) | (reception.packets_lost & 0xFFFFFF)
    rest = (reception.highest_sequence, reception.jitter, reception.last_report, reception.delay)
    return _packet(_RECEIVER_REPORT, 1, struct.pack("!7I", ssrc, source, lost, *rest))


def nack(ssrc: int, source: int, sequences: Iterable[int]) -> bytes:
    """Return a request for packets of `source` by their 16-bit sequence numbers, in the order of sending."""
    entries: list[list[int]] = []
    for sequence in sequences:
        distance = (sequence - entries[-1][0]) & 0xFFFF if entries else 0
        if 1 <= distance <= 16:
            entries[-1][1] |= 1 << distance - 1
        elif not entries or distance:
            entries.append([sequence, 0])
    body = b"".join(struct.pack("!HH", *entry) for entry in entries)
    return _packet(_TRANSPORT_FEEDBACK, _NACK, struct.pack("!II", ssrc, source) + body)


def picture_loss(ssrc: int, source: int) -> bytes:
    """Return a request for a key frame of `source`."""
    return _packet(_PAYLOAD_FEEDBACK, _PLI, struct.pack("!II", ssrc, source))


def bitrate_limit(ssrc: int, source: int, bitrate: int) -> bytes:
    """Return an estimate that the path carries `bitrate` (bit/s) from `source`, rounded down to 18 bits."""
    exponent = max(bitrate.bit_length() - 18, 0)
    limit = exponent << 18 | bitrate >> exponent
    body = struct.pack("!II4sII", ssrc, 0, b"REMB", 1 << 24 | limit, source)
    return _packet(_PAYLOAD_FEEDBACK, _APPLICATION, body)


def _packet(kind: int, count: int, body: bytes) -> bytes:
    return struct.pack("!BBH", 0x80 | count, kind, len(body) // 4) + body
