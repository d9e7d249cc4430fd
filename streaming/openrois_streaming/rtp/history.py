"""What was sent lately, to be sent again, and how much of that may be. Pure."""

from collections.abc import Sequence
from typing import NamedTuple

DEPTH = 1024
"""Packets that are remembered: 2 s of 4 Mbit/s."""

SHARE = 0.5
"""Bytes that may be repeated for each byte of media."""

RESERVE = 100_000
"""Bytes that may be repeated at once: half a second of 1.6 Mbit/s that were lost together."""

KEY_FRAME_TIMES = 2
"""How many times a key frame may be repeated whole, whatever was repeated before it: nothing is seen without it."""

OBSOLETE_SHARE = 0.5
"""Of RESERVE, what is kept for the newest key frame and what follows it: most viewers need nothing before it."""

SHORTEST_WAIT = 0.02
"""Seconds before a packet is repeated again where the round trip is shorter, or unknown."""

LONGEST_WAIT = 0.5
"""Seconds before a packet may be repeated again however long the round trip is."""


class SentFrame(NamedTuple):
    """Packets that left one after the other; their payloads are shared with every other viewer."""

    sequence: int
    """Of the first packet."""
    timestamp: int
    marked: bool
    """Whether the last packet has the marker bit."""
    payloads: Sequence[bytes]


class SentPacket(NamedTuple):
    """A packet as it was sent."""

    sequence: int
    timestamp: int
    marked: bool
    payload: bytes


class History:
    """The last `DEPTH` packets of one sender, and the budget of their repetition.

    A receiver names what it misses; one that lies, or whose path is full, must not multiply what is sent. So a packet
    is repeated once per round trip, and all repetitions together stay below SHARE of what was sent, plus RESERVE.
    """

    __slots__ = ("_budget", "_frames", "_key_frame", "_repeated", "exhausted", "refused")

    def __init__(self) -> None:
        self.refused = 0
        """Packets that were asked for and not sent again, although they are remembered."""
        self.exhausted = False
        """Whether, since the newest key frame, something that came with it or after it was refused for the budget.

        A viewer that still misses it can only be helped by another key frame.
        """
        self._key_frame: int | None = None  # its first packet, while any before it is remembered
        self._frames: list[SentFrame | None] = [None] * DEPTH
        self._repeated: dict[int, float] = {}
        self._budget: float = RESERVE

    def add(self, frame: SentFrame, octets: int) -> None:
        """`frame` was sent, with so many bytes in it."""
        frames, first, count = self._frames, frame.sequence, len(frame.payloads)
        slot = first % DEPTH
        frames[slot : slot + count] = [frame] * count
        over = slot + count - DEPTH
        if over > 0:
            frames[:over] = [frame] * over
            del frames[DEPTH:]
        if self._key_frame is not None and (first - self._key_frame) & 0xFFFF >= DEPTH:
            self._key_frame = None
        self._budget = min(self._budget + octets * SHARE, max(RESERVE, self._budget))

    def key_frame(self, sequence: int, octets: int) -> None:
        """A key frame of so many bytes begins with packet `sequence`, which is added next."""
        self._key_frame = sequence
        self._budget = max(self._budget, octets * KEY_FRAME_TIMES)
        self.exhausted = False

    def again(self, sequence: int, now: float, round_trip: float | None) -> SentPacket | None:
        """The packet `sequence`, if it is to be sent again now."""
        packet = self.find(sequence)
        if packet is None:
            return None
        if now < self._repeated.get(sequence, now):
            self.refused += 1
            return None
        needed = not self._is_obsolete(sequence)
        if self._budget < len(packet.payload) + (0 if needed else OBSOLETE_SHARE * RESERVE):
            self.exhausted |= needed
            self.refused += 1
            return None
        self._budget -= len(packet.payload)
        if len(self._repeated) >= DEPTH:
            self._repeated = {key: until for key, until in self._repeated.items() if until > now}
        self._repeated[sequence] = now + min(max(round_trip or 0.0, SHORTEST_WAIT), LONGEST_WAIT)
        return packet

    def _is_obsolete(self, sequence: int) -> bool:
        """Whether a packet that is remembered was sent before the newest key frame."""
        return self._key_frame is not None and (sequence - self._key_frame) & 0xFFFF >= 0x8000

    def find(self, sequence: int) -> SentPacket | None:
        """The packet `sequence`, if it is remembered; its budget is not asked."""
        frame = self._frames[sequence % DEPTH]
        if frame is None:
            return None
        index = (sequence - frame.sequence) & 0xFFFF
        if index >= len(frame.payloads):
            return None
        last = index == len(frame.payloads) - 1
        return SentPacket(sequence, frame.timestamp, frame.marked and last, frame.payloads[index])
