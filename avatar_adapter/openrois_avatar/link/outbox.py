"""The outgoing queue of an engine: the newest picture, a little sound, every event. Used by `client` only."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Final, Generic, TypeVar

from openrois_avatar.link.messages import Bye, Event
from openrois_avatar.link.protocol import Audio, Doorbell, Encoded, Message, Video

MAX_AUDIO_BLOCKS: Final = 25
"""Half a second of 20 ms blocks."""
MAX_EVENTS: Final = 256
MAX_ENCODED: Final = 8

_Item = TypeVar("_Item")


class Outbox:
    """Filled by the render loop and emptied by one writer thread: events first, then sound, then the newest picture.

    The render loop may `claim` the socket for a moment, to save a small message the way through the other thread.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._events: deque[Event | Bye] = deque()
        self._audio = _Lossy[Audio](MAX_AUDIO_BLOCKS)
        self._video: Video | Doorbell | None = None
        self._encoded: deque[Encoded] = deque()
        self._broken = False
        """Whether an encoded picture was lost, and no key frame has come since."""
        self._dropped_video = 0
        self._open = True
        self._aborted = False
        self._begun = b""
        """The rest of a picture that is sent in part."""
        self._writing = False
        """Whether the socket is in use: by the writer with its message, or by a claim."""

    @property
    def dropped_video(self) -> int:
        """Number of pictures that a newer one replaced."""
        return self._dropped_video

    @property
    def dropped_audio(self) -> int:
        """Number of blocks of sound that newer ones pushed out."""
        return self._audio.dropped

    def put_event(self, event: Event) -> bool:
        """Queue an event; return False if there is no room."""
        with self._changed:
            if len(self._events) >= MAX_EVENTS:
                return False
            self._events.append(event)
            self._changed.notify()
            return True

    def put_audio(self, block: Callable[[int], Audio]) -> None:
        """Queue the block that `block` makes of its sequence number; the oldest gives way."""
        with self._changed:
            self._audio.put(block)
            self._changed.notify()

    def put_video(self, picture: Video | Doorbell) -> None:
        """Put a picture into the mailbox; one that still waits there gives way."""
        with self._changed:
            self._dropped_video += self._video is not None
            self._video = picture
            self._changed.notify()

    def put_encoded(self, picture: Encoded) -> bool:
        """Queue an encoded picture; return False if it, or those before it, were lost, until the next key frame."""
        with self._changed:
            if len(self._encoded) >= MAX_ENCODED:
                self._dropped_video += len(self._encoded)
                self._encoded.clear()
                self._broken = True
            if self._broken and not picture.keyframe:
                self._dropped_video += 1
                return False
            self._broken = False
            self._encoded.append(picture)
            self._changed.notify()
            return True

    def next_message(self) -> Message | bytes | None:
        """Wait for the next message, or the rest of one, and return it; None after the last one."""
        with self._changed:
            self._writing = False
            while True:
                message = None if self._aborted or self._writing else self._next()
                if message is not None or (not self._open and not self._writing):
                    self._writing = message is not None
                    return message
                self._changed.wait()

    def claim(self) -> bool:
        """Claim the socket if nothing waits and it is not in use; return whether it is claimed, until `unclaim`."""
        with self._changed:
            if self._writing or self._waits() or not self._open:
                return False
            self._writing = True
            return True

    def unclaim(self, rest: bytes = b"") -> None:
        """Give the socket back; the rest of a message that has begun is sent first."""
        with self._changed:
            self._writing = False
            self._begun = rest
            if self._waits() or not self._open:
                self._changed.notify()

    def finish(self, farewell: Bye) -> None:
        """End after the events that wait, and `farewell`; sound and pictures are left out."""
        with self._changed:
            if self._open:
                self._audio.queue.clear()
                self._video = None
                self._encoded.clear()
                self._events.append(farewell)
            self._open = False
            self._changed.notify()

    def abort(self) -> None:
        """End now; queued messages are lost."""
        with self._changed:
            self._open = False
            self._aborted = True
            self._changed.notify()

    def _waits(self) -> bool:
        """Return whether there is anything to send."""
        return bool(self._begun or self._events or self._audio.queue or self._video or self._encoded)

    def _next(self) -> Message | bytes | None:
        if self._begun:
            rest, self._begun = self._begun, b""
            return rest
        if self._events:
            return self._events.popleft()
        if self._audio.queue:
            return self._audio.queue.popleft()
        if self._encoded:
            return self._encoded.popleft()
        picture, self._video = self._video, None
        return picture


class _Lossy(Generic[_Item]):
    """A queue that numbers its items and drops the oldest."""

    def __init__(self, size: int) -> None:
        self.queue: deque[_Item] = deque()
        self.dropped = 0
        self._size = size
        self._sequence = 0

    def put(self, make: Callable[[int], _Item]) -> None:
        """Append the item that `make` makes of the next sequence number."""
        if len(self.queue) >= self._size:
            self.queue.popleft()
            self.dropped += 1
        self.queue.append(make(self._sequence))
        self._sequence += 1
