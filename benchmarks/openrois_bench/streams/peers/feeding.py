"""RTP for forwarding senders: the frames of the other senders, sent to a port of this machine."""

import socket
import struct
from contextlib import suppress

from openrois_bench.streams.fanout.encoded import Frames

_PAYLOAD_TYPE = 96
_SSRC = 1


async def feed(port: int) -> None:
    """Send without end (RFC 3550 section 5.1); the receiver may start later."""
    sequence = 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        out.setblocking(False)
        out.connect(("127.0.0.1", port))
        async with Frames().open() as frames:
            async for frame in frames:
                for payload in frame.payloads:
                    marker = 0x80 if payload is frame.payloads[-1] else 0
                    timestamp = frame.pts & 0xFFFFFFFF
                    header = struct.pack("!BBHII", 0x80, marker | _PAYLOAD_TYPE, sequence, timestamp, _SSRC)
                    sequence = sequence + 1 & 0xFFFF
                    with suppress(ConnectionError, BlockingIOError):
                        out.send(header + payload)
