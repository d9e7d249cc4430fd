"""What writes to the adapter: a thread that empties the outbox, and the render loop itself where a moment is enough."""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Callable

from openrois_avatar.link.media import Doorbell
from openrois_avatar.link.messages import LinkError
from openrois_avatar.link.outbox import Outbox
from openrois_avatar.link.protocol import Message, encode


class Writer:
    """Writes to `stream`, whose timeout bounds every write; `fail` is called with the reason when it cannot."""

    def __init__(self, stream: socket.socket, outbox: Outbox, fail: Callable[[str], None]) -> None:
        self._stream = stream
        self._outbox = outbox
        self._fail = fail
        self.thread = threading.Thread(target=self._write, name="engine-link", daemon=True)

    def ring(self, bell: Doorbell) -> None:
        """Send a doorbell at once if the socket is free; else it waits, and the next picture may replace it."""
        if not self._outbox.claim():
            self._outbox.put_video(bell)
            return
        data = b"".join(encode(bell))
        try:
            # Not `send`, which would wait for room. Less than all of so few bytes is hardly ever taken.
            sent = os.write(self._stream.fileno(), data)
            if sent < len(data):
                self._stream.sendall(data[sent:])
        except BlockingIOError:
            self._outbox.put_video(bell)
        except OSError as error:
            self._fail(str(error))
        finally:
            self._outbox.unclaim()

    def _write(self) -> None:
        try:
            while (message := self._outbox.take()) is not None:
                send(self._stream, message)
        except TimeoutError:
            self._fail("the adapter does not read")
        except (OSError, LinkError) as error:
            self._fail(str(error))


def send(stream: socket.socket, message: Message) -> None:
    """Write a message, the header and what follows in one go."""
    header, payload = encode(message)
    sent = stream.sendmsg([header, payload])
    if sent < len(header):
        stream.sendall(header[sent:])
        sent = len(header)
    stream.sendall(memoryview(payload)[sent - len(header) :])
