"""History of sent packets for retransmission, and the budget of retransmissions. Pure."""

from collections.abc import Sequence
from typing import NamedTuple

DEPTH = 1024
"""Packets that are kept: 2 s of 4 Mbit/s."""

SHARE = 0.5
"""Bytes that may be retransmitted for each byte of media."""

RESERVE = 100_000
"""Bytes that may be retransmitted at once: half a second of 1.6 Mbit/s lost together."""

KEY_FRAME_TIMES = 2
"""Times that a whole key frame may be retransmitted, whatever was before: it is needed for every picture."""

OBSOLETE_SHARE = 0.5
"""Share of RESERVE kept for the newest key frame and later packets: most viewers need no earlier ones."""

SHORTEST_WAIT = 0.02
"""Seconds before a packet is retransmitted again if the round trip is shorter, or unknown."""

LONGEST_WAIT = 0.5
"""Seconds before a packet may be retransmitted again, however long the round trip is."""


class SentFrame(NamedTuple):
    """Consecutive packets; their payloads are shared with every other viewer."""

    sequence: int
    """Sequence number of the first packet."""
    timestamp: int
    marked: bool
    """Whether the last packet has the marker bit."""
    payloads: Sequence[bytes]


class SentPacket(NamedTuple):
    """Sent packet."""

    sequence: int
    timestamp: int
    marked: bool
    payload: bytes


class History:
    """Last `DEPTH` packets of one sender, and the budget of their retransmission.

    A receiver that asks for more than it misses, or whose path is full, must not multiply the sent bytes. So a packet
    is retransmitted once per round trip, and all retransmissions stay below SHARE of the sent bytes, plus RESERVE.
    """

    __slots__ = ("_budget", "_frames", "_key_frame", "_repeated", "exhausted", "refused")

    def __init__(self) -> None:
        self.refused = 0
        """Packets that were requested and not retransmitted, although they are kept."""
        self.exhausted = False
        """Whether the budget refused a packet of the newest key frame or later.

        A viewer that still misses it needs another key frame.
        """
        self._key_frame: int | None = None  # its first packet, while an earlier one is kept
        self._frames: list[SentFrame | None] = [None] * DEPTH
        self._repeated: dict[int, float] = {}
        self._budget: float = RESERVE

    def add(self, frame: SentFrame, octets: int) -> None:
        """Add a sent `frame` of so many bytes."""
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
        """Note that a key frame of so many bytes begins with packet `sequence`, which is added next."""
        self._key_frame = sequence
        self._budget = max(self._budget, octets * KEY_FRAME_TIMES)
        self.exhausted = False

    def again(self, sequence: int, now: float, round_trip: float | None) -> SentPacket | None:
        """Return the packet `sequence` if it is to be retransmitted now."""
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
        """Tell whether a kept packet was sent before the newest key frame."""
        return self._key_frame is not None and (sequence - self._key_frame) & 0xFFFF >= 0x8000

    def find(self, sequence: int) -> SentPacket | None:
        """Return the packet `sequence` if it is kept, regardless of the budget."""
        frame = self._frames[sequence % DEPTH]
        if frame is None:
            return None
        index = (sequence - frame.sequence) & 0xFFFF
        if index >= len(frame.payloads):
            return None
        last = index == len(frame.payloads) - 1
        return SentPacket(sequence, frame.timestamp, frame.marked and last, frame.payloads[index])
