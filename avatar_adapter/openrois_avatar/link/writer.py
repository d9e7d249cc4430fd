"""Writing to the adapter: by a thread that empties the outbox, or at once by the render loop."""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Callable
from dataclasses import replace

from openrois_avatar.link.media import Doorbell, Video
from openrois_avatar.link.messages import LinkError
from openrois_avatar.link.outbox import Outbox
from openrois_avatar.link.protocol import Message, encode


class Writer:
    """Writes to `stream`, with its timeout for every write; `fail` is called with the reason of a failure."""

    def __init__(self, stream: socket.socket, outbox: Outbox, fail: Callable[[str], None]) -> None:
        self._stream = stream
        self._outbox = outbox
        self._fail = fail
        self.thread = threading.Thread(target=self._write, name="engine-link", daemon=True)

    def show(self, picture: Video | Doorbell) -> None:
        """Send a picture at once, as far as the socket has room for it; never blocks.

        If the socket is busy or full the picture waits, pixels in a copy, and the next one may replace it; the rest of
        a picture that has begun is sent before anything else.
        """
        if not self._outbox.claim():
            self._outbox.put_video(_kept(picture))
            return
        header, payload = encode(picture)
        rest = b""
        try:
            # Not `send`, which would block.
            sent = os.writev(self._stream.fileno(), [header, payload])
            if sent < len(header) + len(payload):
                rest = b"".join((header[sent:], memoryview(payload)[max(0, sent - len(header)) :]))
        except BlockingIOError:
            self._outbox.put_video(_kept(picture))
        except OSError as error:
            self._fail(str(error))
        finally:
            self._outbox.unclaim(rest)

    def _write(self) -> None:
        try:
            while (message := self._outbox.next_message()) is not None:
                if isinstance(message, bytes):
                    self._stream.sendall(message)
                else:
                    send(self._stream, message)
        except TimeoutError:
            self._fail("the adapter does not read: a write timed out; check that it runs, and connect again")
        except (OSError, LinkError) as error:
            self._fail(str(error))


def _kept(picture: Video | Doorbell) -> Video | Doorbell:
    """Return the picture with pixels that cannot change."""
    if isinstance(picture, Doorbell) or isinstance(picture.pixels, bytes):
        return picture
    return replace(picture, pixels=bytes(picture.pixels))


def send(stream: socket.socket, message: Message) -> None:
    """Write a message, header and payload in one go."""
    header, payload = encode(message)
    sent = stream.sendmsg([header, payload])
    if sent < len(header):
        stream.sendall(header[sent:])
        sent = len(header)
    stream.sendall(memoryview(payload)[sent - len(header) :])
