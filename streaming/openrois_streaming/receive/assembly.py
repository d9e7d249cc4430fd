"""From RTP packets to whole pictures, in order and decodable, and what to ask the sender for meanwhile. Pure."""

from typing import NamedTuple

from openrois_streaming.receive.payloads import Depacketizer, MalformedPayload, Piece
from openrois_streaming.receive.repair import KeyFrameWish, Losses, RoundTrip

PACKETS_LIMIT = 2048
BYTES_LIMIT = 4 << 20
"""What is held of pictures that are not whole yet."""

KEY_FRAME_LIMIT = 4.0
"""Seconds that the rest of a key frame may take which nothing can be shown without."""

_LOSSES_LIMIT = 256
# A packet that is so far from the others belongs to a sender that has started anew.
_LEAP = 1000
_SPOILT = Piece(b"", False, False, False)
# A sender that is silent is not asked for anything.
_SILENCE = 1.0


class VideoPacket(NamedTuple):
    """An RTP packet; `sequence` and `timestamp` are unwrapped, `marker` ends a picture."""

    sequence: int
    timestamp: int
    marker: bool
    payload: bytes


class Picture(NamedTuple):
    """A whole encoded picture.

    A picture that is not `decodable` refers to one that was lost, and no decoder may see it.
    """

    data: bytes
    timestamp: int
    key_frame: bool
    decodable: bool


class Request(NamedTuple):
    """What to ask the sender for: the packets with these sequence numbers, and a key frame."""

    packets: tuple[int, ...]
    key_frame: bool


class _Held(NamedTuple):
    timestamp: int
    marker: bool
    piece: Piece | None
    """None for padding."""


class VideoAssembly:
    """Puts the packets of one source together.

    A picture is released with its last packet: the one with the marker, or the one before another picture's. Pictures
    come in order; behind a gap they wait for the lost packets, until these come, until a key frame is whole, or until
    the patience is over: then everything up to the next key frame is lost, and one is asked for. Of a key frame that is
    waited for, the patience begins anew with each packet that is repaired, for `KEY_FRAME_LIMIT` seconds at most.

    `watched`: whether somebody decodes. If not, nothing is waited for and nothing asked for.
    """

    def __init__(self, depacketize: Depacketizer) -> None:
        self.round_trip = RoundTrip()
        self.duplicates = 0
        self.given_up = 0
        """Gaps that were not repaired in time."""
        self._depacketize = depacketize
        self._watched = False
        self._losses = Losses(self.round_trip)
        self._wish = KeyFrameWish(self.round_trip)
        self._broken = True
        self._packets: dict[int, _Held] = {}
        self._bytes = 0
        self._first: int | None = None
        """The packet that the next picture begins with."""
        self._cursor = 0
        """The first packet from there on that is missing."""
        self._newest = 0
        self._heard_at = 0.0
        self._silent = False

    @property
    def watched(self) -> bool:
        """Whether somebody decodes."""
        return self._watched

    @watched.setter
    def watched(self, watched: bool) -> None:
        self._watched = watched
        self._losses.forget_before(self._newest + 1)
        self._wish.fulfilled()
        self._broken = True
        self._wish.wanted = watched and self._first is not None

    def lose_reference(self) -> None:
        """The decoder begins, or has lost what the next pictures refer to: only a key frame is of use."""
        self._broken = True
        self._wish.wanted = self._watched

    def pause(self) -> None:
        """No packets will be added for a while; what comes after that has nothing to do with what was before."""
        self._packets.clear()
        self._bytes = 0
        self._first = None
        self._losses.forget_before(self._newest + 1)

    def add(self, packet: VideoPacket, now: float) -> list[Picture]:
        """Take a packet in; returns the pictures that are whole by it."""
        self._heard_at, self._silent = now, False
        sequence = packet.sequence
        began = self._first is None or abs(sequence - self._newest) > _LEAP or self._full
        if began:
            self._begin(sequence)
        if sequence < self._cursor or sequence in self._packets:
            self.duplicates += 1
            return []
        held = self._hold(packet)
        self._losses.arrived(sequence, now)
        if began and not (held.piece and held.piece.opens_key):
            self.lose_reference()
        if self._watched and sequence > self._newest + 1:
            self._losses.add(range(self._newest + 1, sequence), now)
        self._newest = max(self._newest, sequence)
        return self._release(now)

    def attend(self, now: float) -> tuple[list[Picture], Request]:
        """To be called after each packet and at `next_at`; returns what is whole by giving up, and what to ask for."""
        pictures = self._release(now)
        self._silent = now - self._heard_at > _SILENCE
        if self._silent or not self._watched:
            return pictures, Request((), key_frame=False)
        lost = self._losses.to_ask_for(now)
        return pictures, Request(lost, not self._is_served and self._wish.due(now))

    @property
    def next_at(self) -> float | None:
        """When `attend` has something to do; None if only a packet can bring that."""
        if not self._watched or self._silent:
            return None
        wish = None if self._is_served else self._wish.next_at
        times = (self._given_up_at, self._losses.next_at, wish)
        return min((each for each in times if each is not None), default=None)

    @property
    def _is_served(self) -> bool:
        """Whether the key frame that is wanted is on its way: its beginning is there."""
        first = self._packets.get(self._first) if self._first is not None else None
        return self._broken and first is not None and first.piece is not None and first.piece.opens_key

    @property
    def _given_up_at(self) -> float | None:
        """When the gap at the cursor is left behind, if it was noticed."""
        gap = self._losses.noticed_at(self._cursor)
        if gap is None:
            return None
        if not self._is_served:
            return gap + self.round_trip.patience
        begun = max(gap, self._losses.repaired_at) + self.round_trip.key_frame_patience
        return min(begun, gap + KEY_FRAME_LIMIT)

    @property
    def _full(self) -> bool:
        return len(self._packets) >= PACKETS_LIMIT or self._bytes >= BYTES_LIMIT or len(self._losses) > _LOSSES_LIMIT

    def _begin(self, sequence: int) -> None:
        self.pause()
        self._first = self._cursor = sequence
        self._newest = sequence - 1
        self._broken = True

    def _hold(self, packet: VideoPacket) -> _Held:
        piece: Piece | None = None
        if packet.payload:
            try:
                piece = self._depacketize(packet.payload)
            except MalformedPayload:
                piece = _SPOILT
            self._bytes += len(piece.data)
        held = self._packets[packet.sequence] = _Held(packet.timestamp, packet.marker, piece)
        return held

    def _release(self, now: float) -> list[Picture]:
        pictures: list[Picture] = []
        while self._first is not None:
            if self._reach_end():
                picture = self._take()
                if picture is not None:
                    pictures.append(picture)
            elif not self._skip(now):
                break
        return pictures

    def _reach_end(self) -> bool:
        """Move the cursor on; whether it stands behind a picture's last packet."""
        first = self._packets.get(self._first) if self._first is not None else None
        while (held := self._packets.get(self._cursor)) is not None and first is not None:
            if held.timestamp != first.timestamp:
                return True
            self._cursor += 1
            if held.marker or first.piece is None:
                return True
        return False

    def _take(self) -> Picture | None:
        assert self._first is not None, "a picture has a first packet"
        held = [self._packets.pop(sequence) for sequence in range(self._first, self._cursor)]
        self._first = self._cursor
        pieces = [each.piece for each in held if each.piece is not None]
        data = b"".join(piece.data for piece in pieces)
        self._bytes -= len(data)
        if not pieces:
            return None
        if not pieces[0].begins or any(piece is _SPOILT for piece in pieces):
            self.lose_reference()
            return None
        key_frame = any(piece.key for piece in pieces)
        if key_frame:
            self._broken = False
            self._wish.fulfilled()
        elif self._broken:
            self._wish.wanted = self._watched
        return Picture(data, held[0].timestamp, key_frame, not self._broken)

    def _skip(self, now: float) -> bool:
        """Leave a gap behind that is not worth waiting for; whether that was done."""
        if self._newest < self._cursor:
            return False
        whole = self._whole_key_frame()
        if whole is not None:
            self._leave_behind(whole)
            return True
        given_up_at = self._given_up_at
        if given_up_at is not None and now < given_up_at and not self._hopeless():
            return False
        self.given_up += 1
        self._leave_behind(min(sequence for sequence in self._packets if sequence > self._cursor))
        self.lose_reference()
        return True

    def _hopeless(self) -> bool:
        """Whether what stands before the gap cannot be decoded anyway."""
        first = self._packets.get(self._first) if self._first is not None else None
        return self._broken and (first is None or first.piece is None or not first.piece.opens_key)

    def _whole_key_frame(self) -> int | None:
        """The first packet of a key frame behind the gap of which everything is there."""
        # Once through all of them: who sends decides how many there are, and each may be the first of a key frame.
        start: int | None = None
        following, timestamp = 0, 0
        for sequence in sorted(each for each in self._packets if each > self._cursor):
            held = self._packets[sequence]
            if sequence != following or held.timestamp != timestamp:
                start = None
            if start is None and held.piece and held.piece.opens_key:
                start = sequence
            if start is not None and held.marker:
                return start
            following, timestamp = sequence + 1, held.timestamp
        return None

    def _leave_behind(self, sequence: int) -> None:
        for old in [each for each in self._packets if each < sequence]:
            piece = self._packets.pop(old).piece
            self._bytes -= len(piece.data) if piece else 0
        self._first = self._cursor = sequence
        self._losses.forget_before(sequence)
