"""The game engine's side of the engine link: blocking sockets and one writer thread, made for a render loop.

    with connect_from_environment(Hello("puppet", "1.0", VideoShape(640, 360, 30))) as link:
        while link.connected:
            for command in link.poll_commands():
                ...
            link.send_video(pixels, 640, 360, 640 * 4, PixelFormat.BGRA, time.monotonic_ns())

Nothing here waits for the adapter: pictures are sent as far as the socket has room, or else go to a mailbox that holds
the newest one; sound and events go to short queues; and a thread writes them out. It needs the standard library and
NumPy only.
"""

from __future__ import annotations

import contextlib
import os
import selectors
import socket
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import count
from types import TracebackType
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from openrois_avatar.link.address import ADDRESS_VARIABLE, SECRET_VARIABLE, connect_socket, parse_address
from openrois_avatar.link.media import Doorbell, Encoded, check_picture, picture_size
from openrois_avatar.link.messages import Bye, Command, Event, Hello, LinkError, Log, RingPlace, Welcome
from openrois_avatar.link.outbox import MAX_AUDIO_BLOCKS, Outbox
from openrois_avatar.link.protocol import Audio, Message, Parser, PixelFormat, Sender, Video
from openrois_avatar.link.ring_writer import RingWriter
from openrois_avatar.link.writer import Writer, send

STALL_TIMEOUT: Final = 10.0
"""Seconds after which an adapter that reads nothing counts as disconnected."""
FAREWELL_TIMEOUT: Final = 0.5
"""Seconds that `close` gives the writer to send its queue, above all the last events."""
_READ_SIZE: Final = 64 * 1024


class LinkClient:
    """A connection to the adapter, used by one thread; `connected` tells a render loop when to stop."""

    def __init__(self, stream: socket.socket) -> None:
        """Use `connect`; `stream` is connected, and no message has been sent on it."""
        self._stream = stream
        self._parser = Parser(Sender.ADAPTER)
        self._commands: deque[Command] = deque()
        self._heard: deque[Audio] = deque(maxlen=MAX_AUDIO_BLOCKS)
        self._selector = selectors.DefaultSelector()
        self._selector.register(stream, selectors.EVENT_READ)
        self._outbox = Outbox()
        self._numbers = count()
        self._ring: RingWriter | None = None
        self._reason: str | None = None
        self._failure: str | None = None
        self._writer = Writer(stream, self._outbox, self._fail)

    @classmethod
    def connect(cls, address: str, hello: Hello, timeout: float = 5.0) -> Self:
        """Connect, send HELLO, and wait for WELCOME; `timeout` seconds at most for all of it.

        Raises:
            LinkError: no adapter answers, it refuses (the text has its reason), or it breaks the protocol.
        """
        deadline = time.monotonic() + timeout
        stream = connect_socket(parse_address(address), timeout)
        if stream.family == socket.AF_UNIX:
            # One write takes a whole picture then, and the adapter wakes once for it. TCP finds its size by itself.
            stream.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, hello.video.width * hello.video.height * 4)
        client = cls(stream)
        try:
            client._greet(hello, deadline)
        except TimeoutError as error:
            client._release()
            raise LinkError(
                f"{address} has not answered HELLO within {timeout:g} s; check that an adapter listens there"
            ) from error
        except (OSError, LinkError) as error:
            client._release()
            raise LinkError(str(error)) from error
        stream.settimeout(STALL_TIMEOUT)
        client._writer.thread.start()
        return client

    def __enter__(self) -> Self:
        return self

    def __exit__(self, _kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        self.close("the engine failed" if error else "the engine ends")

    @property
    def connected(self) -> bool:
        """False once `poll_commands` has found the connection closed, or BYE; `reason` then says why."""
        return self._reason is None

    @property
    def reason(self) -> str | None:
        """The reason for which the link has ended; None while it has not."""
        return self._reason

    @property
    def dropped_video(self) -> int:
        """Number of pictures that a newer one replaced before they could be sent."""
        return self._outbox.dropped_video

    @property
    def dropped_audio(self) -> int:
        """Number of blocks of sound dropped, oldest first, because the adapter read too slowly."""
        return self._outbox.dropped_audio

    def send_video(
        self,
        pixels: Any,
        width: int,
        height: int,
        stride: int,
        format: PixelFormat,
        timestamp_ns: int,
        bottom_up: bool = False,
    ) -> None:
        """Send a picture captured at `timestamp_ns` (CLOCK_MONOTONIC); it replaces one that still waits.

        If HELLO asked for a ring and the adapter has given one, the pixels go there, but for pictures that are larger
        than its slots.

        `pixels` is any C-contiguous buffer. Unless it is `bytes`, the part that the socket has no room for is copied,
        so that the caller may draw the next picture into the same buffer at once.

        Raises:
            LinkError: the numbers do not describe the pixels.
        """
        view = memoryview(pixels).cast("B")
        check_picture(width, height, stride, format, len(view))
        sequence = next(self._numbers)
        shape = sequence, timestamp_ns, width, height, stride, format
        slot = None if self._ring is None else self._ring.write(sequence, view)
        if slot is not None:
            self._writer.show(Doorbell(*shape, slot, bottom_up))
        else:
            self._writer.show(Video(*shape, pixels if isinstance(pixels, bytes) else view, bottom_up))

    def draw_video(
        self,
        draw: Callable[[NDArray[np.uint8]], None],
        width: int,
        height: int,
        format: PixelFormat,
        timestamp_ns: int,
    ) -> None:
        """Send a picture as `send_video` does, which `draw` writes straight into the ring: it is copied once less.

        `draw` gets a flat array for the bytes of the picture, without padding and with any content; it writes all of
        them, and touches them no more when it has returned. Without a ring the array is memory of this process. An
        exception of `draw` is raised here, and no picture is sent.

        Raises:
            LinkError: size or format are not allowed.
        """
        stride = width * (4 if format is PixelFormat.BGRA else 1)
        size = picture_size(width, height, stride, format)
        sequence = next(self._numbers)
        shape = sequence, timestamp_ns, width, height, stride, format
        begun = None if self._ring is None else self._ring.begin(sequence, size)
        if self._ring is None or begun is None:
            pixels = np.empty(size, np.uint8)
            draw(pixels)
            self._writer.show(Video(*shape, pixels.data))
        else:
            slot, room = begun
            draw(np.frombuffer(room, np.uint8))
            self._ring.finish(sequence, slot)
            self._writer.show(Doorbell(*shape, slot))

    def send_encoded(self, data: bytes, width: int, height: int, timestamp_ns: int, *, keyframe: bool) -> bool:
        """Send a picture that the engine has encoded: an H.264 access unit in Annex B form, constrained baseline.

        Key frames are IDR pictures with SPS and PPS before them. All pictures are sent in order, as long as the adapter
        reads: False says that some were lost, and that the next one has to be a key frame.

        Raises:
            LinkError: size or length are not allowed.
        """
        picture = Encoded(next(self._numbers), timestamp_ns, width, height, keyframe, data)
        return self._outbox.put_encoded(picture)

    def send_audio(self, samples: NDArray[np.int16], timestamp_ns: int) -> None:
        """Send a block of 48 kHz sound, shape (n, channels), with the timestamp of its first sample.

        Raises:
            LinkError: more than 64 KiB, or neither one nor two channels.
        """
        block = Audio(0, timestamp_ns, samples.shape[1], np.ascontiguousarray(samples, dtype="<i2").tobytes())
        self._outbox.put_audio(lambda sequence: replace(block, sequence=sequence))

    def send_event(self, event: Event) -> None:
        """Send an event. Events are never dropped: a link on which 256 of them wait is closed instead."""
        if not self._outbox.put_event(event):
            self._fail("the adapter reads too slowly: 256 events wait; send fewer, and connect again")

    def poll_commands(self, timeout: float = 0.0) -> list[Command]:
        """Return the commands since the last call, in order; wait up to `timeout` seconds for a first one.

        Never raises: when the link has ended the list is empty and `connected` is False.
        """
        deadline = time.monotonic() + timeout
        try:
            while self.connected and self._selector.select(self._patience(deadline)):
                for message in self._read():
                    self._handle_message(message)
        except (OSError, LinkError) as error:
            self._end_link(self._failure or str(error))
        commands = list(self._commands)
        self._commands.clear()
        return commands

    def poll_audio(self) -> list[NDArray[np.int16]]:
        """Return the operator's sound since the last call, in order: blocks of shape (n, channels), 48 kHz.

        They arrive while `poll_commands` is called, and only if HELLO said that the engine hears. Of more than 25
        blocks the oldest are lost.
        """
        blocks = [np.frombuffer(block.samples, dtype="<i2").reshape(-1, block.channels) for block in self._heard]
        self._heard.clear()
        return blocks

    def close(self, reason: str = "the engine ends") -> None:
        """Send the events that wait and BYE, and release everything; half a second at most. May be repeated."""
        self._outbox.finish(Bye(reason))
        self._writer.thread.join(FAREWELL_TIMEOUT)
        self._end_link(reason)
        self._writer.thread.join()  # returns at once: the socket is shut down and the outbox aborted
        self._release()

    def _patience(self, deadline: float) -> float:
        return 0.0 if self._commands else max(0.0, deadline - time.monotonic())

    def _greet(self, hello: Hello, deadline: float) -> None:
        with contextlib.suppress(
            OSError
        ):  # an adapter that has closed already has sent its reason, which is read below
            send(self._stream, hello)
        messages: list[Message] = []
        while not messages:
            self._stream.settimeout(max(0.001, deadline - time.monotonic()))
            messages = self._read()
        first, *later = messages
        if not isinstance(first, Welcome):
            raise LinkError(f"refused: {first.reason}" if isinstance(first, Bye) else "refused")
        self._open_ring(first.ring)
        for message in later:
            self._handle_message(message)

    def _open_ring(self, place: RingPlace | None) -> None:
        if place is not None:
            try:
                self._ring = RingWriter(place)
            except LinkError as error:
                self.send_event(Log(f"{error}; pictures go through the socket"))

    def _read(self) -> list[Message]:
        data = self._stream.recv(_READ_SIZE)
        if not data:
            raise LinkError("the adapter closed the connection; connect again")
        return self._parser.feed(data)

    def _handle_message(self, message: Message) -> None:
        if isinstance(message, Bye):
            self._end_link(message.reason)
        elif isinstance(message, Audio):
            self._heard.append(message)
        else:
            assert isinstance(message, Command), "the parser accepts nothing else of an adapter"
            self._commands.append(message)

    def _fail(self, failure: str) -> None:
        """Shut the socket down, from either thread. A BYE of the adapter may still be unread, and says more."""
        self._failure = self._failure or failure
        self._outbox.abort()
        with contextlib.suppress(OSError):  # it may be down already
            self._stream.shutdown(socket.SHUT_RDWR)

    def _end_link(self, reason: str) -> None:
        self._reason = self._reason or reason
        self._fail(reason)

    def _release(self) -> None:
        self._selector.close()
        self._stream.close()


def connect_from_environment(
    hello: Hello, timeout: float = 10.0, environ: Mapping[str, str] = os.environ
) -> LinkClient:
    """Connect to the adapter that the environment names, with `hello` and the secret of the environment.

    Raises:
        LinkError: as `LinkClient.connect`, or the environment has no address.
    """
    address = environ.get(ADDRESS_VARIABLE)
    if address is None:
        raise LinkError(
            f"{ADDRESS_VARIABLE} is not set; start the engine from the adapter, or set it to the adapter's --link"
        )
    return LinkClient.connect(address, replace(hello, secret=environ.get(SECRET_VARIABLE, "")), timeout)
