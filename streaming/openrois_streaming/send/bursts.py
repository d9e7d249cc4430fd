"""Sending of datagrams of one length in one system call, which kernel or network card segment (UDP GSO)."""

import errno
import socket
import struct
from collections.abc import Iterator, Sequence
from typing import Final

UDP_SEGMENT: Final = 103  # of linux/udp.h; Python has no name for it
SEGMENTS_LIMIT: Final = 48
"""Datagrams in one call. The kernel takes 64, and 65,507 bytes."""
_BYTES_LIMIT: Final = 64_000
# A network card without checksums of its own, for example (udp_send_skb of Linux).
_UNABLE: Final = frozenset({errno.EIO, errno.EINVAL, errno.EOPNOTSUPP})

Address = tuple[str, int]


class BurstSocket:
    """Second handle to a socket of a media transport, for sending without waiting. To be closed.

    If the system cannot send several datagrams in one call, each has a call of its own. Datagrams that the socket
    refuses are lost, as anywhere on their path.
    """

    __slots__ = ("_segmenting", "_socket", "lost")

    def __init__(self, descriptor: int, family: int) -> None:
        self.lost = 0
        """Datagrams that the socket refused."""
        self._socket = socket.socket(family, socket.SOCK_DGRAM, socket.IPPROTO_UDP, fileno=descriptor)
        self._socket.setblocking(False)
        self._segmenting = True
        try:
            self._socket.getsockopt(socket.IPPROTO_UDP, UDP_SEGMENT)
        except OSError:
            self._segmenting = False

    def send(self, datagrams: Sequence[bytes], address: Address) -> None:
        """Send datagrams in order; never waits, never raises OSError."""
        if not self._segmenting:
            self._send_each(datagrams, address)
            return
        for first, end in runs(list(map(len, datagrams))):
            if end - first == 1:
                self._send_each(datagrams[first:end], address)
            else:
                self._send_run(datagrams[first:end], address)

    def close(self) -> None:
        """Close this handle; the original socket stays open."""
        self._socket.close()

    def _send_run(self, datagrams: Sequence[bytes], address: Address) -> None:
        length = struct.pack("=H", len(datagrams[0]))
        try:
            self._socket.sendmsg(datagrams, [(socket.IPPROTO_UDP, UDP_SEGMENT, length)], 0, address)
        except BlockingIOError:
            self.lost += len(datagrams)
        except OSError as error:
            if error.errno in _UNABLE:
                self._segmenting = False
            self._send_each(datagrams, address)

    def _send_each(self, datagrams: Sequence[bytes], address: Address) -> None:
        for datagram in datagrams:
            try:
                self._socket.sendto(datagram, address)
            except OSError:
                self.lost += 1


def runs(lengths: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Split `lengths` into runs for one call each: all of one length, but for a shorter last one. Pure."""
    first = 0
    while first < len(lengths):
        step, end = lengths[first], first + 1
        limit = min(len(lengths), first + min(SEGMENTS_LIMIT, _BYTES_LIMIT // max(step, 1)))
        while end < limit and lengths[end] == step:
            end += 1
        if end < limit and lengths[end] < step:
            end += 1
        yield first, end
        first = end
