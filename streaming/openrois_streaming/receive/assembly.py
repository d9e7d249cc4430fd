"""Assembly of RTP packets into whole pictures, in order and decodable, with requests to the sender. Pure."""

from typing import NamedTuple

from openrois_streaming.receive.payloads import Depacketizer, MalformedPayload, Piece
from openrois_streaming.receive.repair import KeyFrameWish, Losses, RoundTrip

PACKETS_LIMIT = 2048
BYTES_LIMIT = 4 << 20
"""Limits on the packets and bytes of incomplete pictures."""

KEY_FRAME_LIMIT = 4.0
"""Seconds that the rest of an awaited key frame may take."""

_LOSSES_LIMIT = 256
# A packet so far from the others belongs to a sender that has restarted.
_LEAP = 1000
_SPOILT = Piece(b"", False, False, False)
# A silent sender gets no requests.
_SILENCE = 1.0


class VideoPacket(NamedTuple):
    """RTP packet; `sequence` and `timestamp` are unwrapped, `marker` ends a picture."""

    sequence: int
    timestamp: int
    marker: bool
    payload: bytes


class Picture(NamedTuple):
    """Whole encoded picture.

    A picture that is not `decodable` refers to a lost one, and no decoder may get it.
    """

    data: bytes
    timestamp: int
    key_frame: bool
    decodable: bool


class Request(NamedTuple):
    """Request to the sender: the packets with these sequence numbers, and a key frame."""

    packets: tuple[int, ...]
    key_frame: bool


class _Held(NamedTuple):
    timestamp: int
    marker: bool
    piece: Piece | None
    """None for padding."""


class VideoAssembly:
    """Assembly of the pictures of one source.

    A picture is released with its last packet: the one with the marker, or the one before another picture's. Pictures
    come in order; behind a gap they wait for the lost packets, until these come, until a key frame is whole, or until
    the patience is over: then everything up to the next key frame is lost, and one is requested. For an awaited key
    frame the patience begins anew with each repaired packet, for `KEY_FRAME_LIMIT` seconds at most.

    `watched`: whether the pictures are decoded. If not, there is no waiting and no request.
    """

    def __init__(self, depacketize: Depacketizer) -> None:
        self.round_trip = RoundTrip()
        self.duplicates = 0
        self.given_up = 0
        """Number of gaps that were not repaired in time."""
        self._depacketize = depacketize
        self._watched = False
        self._losses = Losses(self.round_trip)
        self._wish = KeyFrameWish(self.round_trip)
        self._broken = True
        self._packets: dict[int, _Held] = {}
        self._bytes = 0
        self._first: int | None = None
        """Number of the first packet of the next picture."""
        self._cursor = 0
        """Number of the first missing packet from there on."""
        self._newest = 0
        self._last_packet_at = 0.0
        self._silent = False

    @property
    def watched(self) -> bool:
        """Whether the pictures are decoded."""
        return self._watched

    @watched.setter
    def watched(self, watched: bool) -> None:
        self._watched = watched
        self._losses.forget_before(self._newest + 1)
        self._wish.fulfilled()
        self._broken = True
        self._wish.wanted = watched and self._first is not None

    def lose_reference(self) -> None:
        """Wait for a key frame: the decoder begins, or lacks the pictures that the next ones refer to."""
        self._broken = True
        self._wish.wanted = self._watched

    def pause(self) -> None:
        """Drop incomplete pictures: packets after a pause have no relation to earlier ones."""
        self._packets.clear()
        self._bytes = 0
        self._first = None
        self._losses.forget_before(self._newest + 1)

    def add(self, packet: VideoPacket, now: float) -> list[Picture]:
        """Add a packet; returns the pictures that it completes."""
        self._last_packet_at, self._silent = now, False
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

    def check_deadlines(self, now: float) -> tuple[list[Picture], Request]:
        """Give up gaps that are due, after each packet and at `next_at`; returns the freed pictures, and requests."""
        pictures = self._release(now)
        self._silent = now - self._last_packet_at > _SILENCE
        if self._silent or not self._watched:
            return pictures, Request((), key_frame=False)
        lost = self._losses.to_ask_for(now)
        return pictures, Request(lost, not self._is_served and self._wish.due(now))

    @property
    def next_at(self) -> float | None:
        """Time of the next `check_deadlines`; None if only a packet can make it due."""
        if not self._watched or self._silent:
            return None
        wish = None if self._is_served else self._wish.next_at
        times = (self._given_up_at, self._losses.next_at, wish)
        return min((each for each in times if each is not None), default=None)

    @property
    def _is_served(self) -> bool:
        """Whether the wanted key frame is arriving: its first packet is there."""
        first = self._packets.get(self._first) if self._first is not None else None
        return self._broken and first is not None and first.piece is not None and first.piece.opens_key

    @property
    def _given_up_at(self) -> float | None:
        """Time at which the gap at the cursor is given up, if it was noticed."""
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
                picture = self._finish_picture()
                if picture is not None:
                    pictures.append(picture)
            elif not self._skip(now):
                break
        return pictures

    def _reach_end(self) -> bool:
        """Advance the cursor; whether it stands behind a picture's last packet."""
        first = self._packets.get(self._first) if self._first is not None else None
        while (held := self._packets.get(self._cursor)) is not None and first is not None:
            if held.timestamp != first.timestamp:
                return True
            self._cursor += 1
            if held.marker or first.piece is None:
                return True
        return False

    def _finish_picture(self) -> Picture | None:
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
        """Give up a gap that is not worth waiting for; whether that was done."""
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
        """Tell whether the pictures before the gap cannot be decoded anyway."""
        first = self._packets.get(self._first) if self._first is not None else None
        return self._broken and (first is None or first.piece is None or not first.piece.opens_key)

    def _whole_key_frame(self) -> int | None:
        """Return the first packet of a whole key frame behind the gap; None if there is none."""
        # One pass over all of them: the sender decides how many there are, and each may be the first of a key frame.
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
