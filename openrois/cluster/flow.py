"""Numbers and credit of a stream's two directions: nothing is lost unnoticed, and no queue grows without end. Pure.

A message costs its bytes and `MESSAGE_COST`; so does each piece of a long one. The receiver grants how much may be sent
in all, and grants more as its application takes messages in.
"""

from collections import deque
from collections.abc import Iterator, Sequence
from typing import Final

from openrois.cluster.frames import Frame, FrameFault, FrameGap, Kind, pack_frame, pack_texts, parse_texts

__all__ = ["MAX_MESSAGE", "MESSAGE_COST", "PIECE", "WINDOW", "Receiving", "Sending"]

WINDOW: Final = 1 << 20
"""Cost of what may wait at the receiver of a stream, a message that is just being put together aside."""

MAX_MESSAGE: Final = 32 << 20
"""Bytes of one incoming message. A stream holds at most `WINDOW` and one message in memory."""

PIECE: Final = 512 << 10
"""Bytes of a frame's body at most; NATS may be set to less."""

BATCH: Final = 64 << 10
"""Bytes of messages that share a frame."""

MESSAGE_COST: Final = 64
"""What a message costs beside its bytes: very many very short ones fill a memory, too."""


class Sending:
    """The direction away from here.

    Args:
        window: what the other side takes in before it grants more.
        piece: bytes of a body at most.
    """

    def __init__(self, window: int, piece: int) -> None:
        # Credit comes when a quarter of the window is free: what is larger than the rest might wait for ever.
        self.piece = min(piece, window // 2)
        self._granted = window
        self._spent = 0
        self._number = 0

    def allows(self, cost: int) -> bool:
        """Tell whether so much may be sent now."""
        return self._spent + cost <= self._granted

    def grant(self, granted: int) -> None:
        """Note that so much may be sent in all.

        Raises:
            FrameFault: it is less than before.
        """
        if granted < self._granted:
            raise FrameFault("credit that was granted is taken back")
        self._granted = granted

    def frame(self, kind: Kind, body: bytes = b"", cost: int = 0) -> bytes:
        """Return the next frame, and count its cost."""
        data = pack_frame(kind, self._number, body)
        self._number += 1
        self._spent += cost
        return data

    def pieces(self, data: bytes) -> Iterator[tuple[Kind, bytes, int]]:
        """Yield kind, body and cost of the frames of a message."""
        if len(data) <= self.piece:
            yield Kind.TEXT, data, len(data) + MESSAGE_COST
            return
        for at in range(0, len(data), self.piece):
            body = data[at : at + self.piece]
            yield (Kind.PART if at + self.piece < len(data) else Kind.LAST), body, len(body) + MESSAGE_COST

    def batches(self, texts: Sequence[bytes]) -> Iterator[tuple[Kind, bytes, int]]:
        """Yield kind, body and cost of the frames of several messages, as few as there can be."""
        most = min(BATCH, self.piece)
        waiting: list[bytes] = []
        size = 0
        for text in texts:
            # Each stands after its length.
            if waiting and size + len(text) + 4 > most:
                yield _together(waiting)
                waiting, size = [], 0
            if len(text) + 4 > most:
                yield from self.pieces(text)
            else:
                waiting.append(text)
                size += len(text) + 4
        if waiting:
            yield _together(waiting)


def _together(texts: Sequence[bytes]) -> tuple[Kind, bytes, int]:
    cost = sum(map(len, texts)) + MESSAGE_COST * len(texts)
    if len(texts) == 1:
        return Kind.TEXT, texts[0], cost
    return Kind.TEXTS, pack_texts(texts), cost


class Receiving:
    """The direction that comes here.

    Args:
        window: cost of what may wait.
        max_message: bytes of one message.
    """

    def __init__(self, window: int = WINDOW, max_message: int = MAX_MESSAGE) -> None:
        self._window = window
        self._max_message = max_message
        self._number = 0
        self._messages: deque[tuple[bytes | bytearray, int]] = deque()
        self._begun: bytearray | None = None
        self._unreleased = 0
        self._granted = window
        self._came = 0
        self._released = 0

    def __len__(self) -> int:
        """Return how many messages wait."""
        return len(self._messages)

    @property
    def held(self) -> int:
        """Bytes of messages that wait, or are put together."""
        return len(self._begun or b"") + sum(len(data) for data, _ in self._messages)

    def count(self, number: int) -> None:
        """Count a frame that came.

        Raises:
            FrameGap: it is not the next one.
        """
        if number != self._number:
            raise FrameGap(f"frame {number} came where {self._number} was due")
        self._number += 1

    def put(self, frame: Frame) -> None:
        """Take a frame with messages in, or a piece of one.

        Raises:
            FrameFault: it may not come here.
            OverflowError: the message is too long.
        """
        kind, body = frame.kind, frame.body
        if kind is Kind.TEXT:
            self._require_whole()
            self._put_message(body)
        elif kind is Kind.TEXTS:
            self._require_whole()
            for text in parse_texts(body):
                self._put_message(text)
        elif kind is Kind.PART:
            self._put_part(bytearray() if self._begun is None else self._begun, body)
        elif kind is Kind.LAST and self._begun is not None:
            self._put_part(self._begun, body)
            self._messages.append((self._begun, self._unreleased))
            self._begun, self._unreleased = None, 0
        else:
            raise FrameFault(f"a frame of kind {kind.name} came where a message was due")

    def _require_whole(self) -> None:
        if self._begun is not None:
            raise FrameFault("a message came within another")

    def _put_message(self, data: bytes) -> None:
        self._require_short(len(data))
        self._messages.append((data, self._counted(data)))

    def _put_part(self, begun: bytearray, data: bytes) -> None:
        self._require_short(len(begun) + len(data))
        self._unreleased += self._counted(data)
        begun += data
        self._begun = begun
        self._release_parts()

    def _require_short(self, size: int) -> None:
        if size > self._max_message:
            raise OverflowError(f"a message has at most {self._max_message} bytes")

    def _counted(self, data: bytes) -> int:
        cost = len(data) + MESSAGE_COST
        self._came += cost
        if self._came > self._granted:
            raise FrameFault("more came than was granted")
        return cost

    def _release_parts(self) -> None:
        # What stands before a message that is put together has to be received first.
        if not self._messages:
            self._released += self._unreleased
            self._unreleased = 0

    def pop(self) -> bytes | bytearray:
        """Return the next message: there has to be one."""
        data, cost = self._messages.popleft()
        self._released += cost
        self._release_parts()
        return data

    def next_grant(self) -> int | None:
        """Return how much may be sent in all, if that is worth a frame."""
        most = self._released + self._window
        if most - self._granted < self._window // 4:
            return None
        self._granted = most
        return most

    def discard(self) -> None:
        """Drop all that came."""
        self._messages.clear()
        self._begun, self._unreleased = None, 0
