"""The other end of the engine link, by hand: an adapter made of one blocking socket, and messages to send."""

import socket
import threading
from collections import deque
from types import TracebackType
from typing import Self

from openrois_avatar.link.messages import Hello, VideoShape, Welcome
from openrois_avatar.link.protocol import Audio, Message, Parser, PixelFormat, Sender, Video, encode

HELLO = Hello("puppet", "1.0", VideoShape(4, 2, 30), 2, ("nod", "bow"), "secret", hears=True)


def wire(*messages: Message) -> bytes:
    return b"".join(b"".join(encode(message)) for message in messages)


def picture(sequence: int = 0, timestamp_ns: int = 0) -> Video:
    return Video(sequence, timestamp_ns, 4, 2, 16, PixelFormat.BGRA, bytes(range(32)))


def plain(message: Message) -> Message:
    """With pixels and samples as bytes, so that messages can be compared."""
    match message:
        case Video(sequence, timestamp, width, height, stride, pixel_format, pixels, bottom_up):
            return Video(sequence, timestamp, width, height, stride, pixel_format, bytes(pixels), bottom_up)
        case Audio(sequence, timestamp, channels, samples):
            return Audio(sequence, timestamp, channels, bytes(samples))
        case other:
            return other


class FakeAdapter:
    """Answers the first HELLO with `answer`; everything else is sent by the test."""

    def __init__(self, answer: bytes = wire(Welcome("adapter"))) -> None:
        self._answer = answer
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._listener.settimeout(5)
        self._parser = Parser(Sender.ENGINE)
        self._messages: deque[Message] = deque()
        self._stream: socket.socket | None = None
        self._thread = threading.Thread(target=self._greet)
        self.address = f"tcp:127.0.0.1:{self._listener.getsockname()[1]}"

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._thread.join(10)
        self.hang_up()
        self._listener.close()

    @property
    def stream(self) -> socket.socket:
        self._thread.join(10)
        assert self._stream is not None
        return self._stream

    def send(self, *messages: Message) -> None:
        self.stream.sendall(wire(*messages))

    def read(self) -> Message | None:
        """The next message, None at the end of the connection."""
        while not self._messages:
            data = self.stream.recv(1 << 20)
            if not data:
                return None
            self._messages += self._parser.feed(data)
        return plain(self._messages.popleft())

    def hang_up(self) -> None:
        if self._stream is not None:
            self._stream.close()

    def _greet(self) -> None:
        self._stream, _ = self._listener.accept()
        self._stream.settimeout(5)
        while not self._messages:
            self._messages += self._parser.feed(self._stream.recv(1 << 20))
        if self._answer:
            self._stream.sendall(self._answer)
        else:
            self._stream.close()
