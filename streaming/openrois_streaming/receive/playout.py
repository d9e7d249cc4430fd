"""Sound that arrives in packets, played without a break: late, lost and superfluous ones are made up for. Pure."""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from openrois_streaming.receive.jitter import TargetDelay
from openrois_streaming.receive.stretch import Samples, longer, shorter
from openrois_streaming.source.source import SAMPLE_RATE

BLOCK = SAMPLE_RATE // 100
"""Samples that are played at a time, at most: 10 ms."""

PACKETS_LIMIT = 128
"""Packets that wait to be played."""

# The delay may be so much above what is needed before sound is shortened, and so much below before it is made longer.
# Together they are more than is put in at once, so that this is not taken out again.
_ABOVE, _BELOW = 0.008, 0.001
_PUT_IN = round(0.0075 * SAMPLE_RATE)
# With so much too much, not only where sound is periodic or quiet; and with so much, whole packets are left out.
_FAR_ABOVE, _ABSURD = 0.03, 0.1
# Samples that are made up as loud as the sound was, and after how many there is silence.
_LOUD, _SILENT = round(0.04 * SAMPLE_RATE), round(0.24 * SAMPLE_RATE)
_FADE = SAMPLE_RATE // 200


class SoundDecoder(Protocol):
    """Decodes the packets of one source in their order, in stereo."""

    def decode(self, payload: bytes) -> Samples:
        """The sound of a packet.

        Raises:
            UndecodableSound: it has none.
        """
        ...

    def conceal(self) -> Samples:
        """A block that goes on as the sound did before."""
        ...


class UndecodableSound(ValueError):
    """A packet without sound in it."""


class SoundPacket(NamedTuple):
    """`timestamp` is unwrapped, in samples."""

    timestamp: int
    payload: bytes


class Block(NamedTuple):
    """`BLOCK` samples at most, and the timestamp of the first of them."""

    samples: Samples
    timestamp: int


@dataclass
class PlayoutFigures:
    """What was done to the sound so far; in samples, packets where it says so."""

    concealed: int = 0
    shortened: int = 0
    lengthened: int = 0
    late: int = 0
    """Packets that came when their time was over."""
    skipped: int = 0
    """Packets that were left out to catch up."""


class Playout:
    """The playout buffer of one source.

    Packets go in with `add` when they arrive. `play` is called whenever the block before is over: a block ends with its
    packet where the next one may not be there yet. A packet is played when the delay that `TargetDelay` asks for is
    over. Where the delay is higher, periods of the sound are left out; where it has to be higher, some are repeated.
    """

    def __init__(self, decoder: SoundDecoder) -> None:
        self.figures = PlayoutFigures()
        self.target = TargetDelay()
        self.played_delay = 0.0
        """The delay of the block that was played last, in seconds."""
        self._decoder = decoder
        self._waiting: dict[int, bytes] = {}
        self._pending: Samples = np.empty((0, 2), np.int16)
        self._position: int | None = None
        """The timestamp behind what was decoded last."""
        self._concealing = 0
        """Samples that were made up since the last ones that are real."""

    def add(self, packet: SoundPacket, arrival: float) -> None:
        """A packet came at `arrival` (seconds)."""
        if self.target.arrived(packet.timestamp / SAMPLE_RATE, arrival) and self._position is not None:
            self._waiting.clear()
            self._position = packet.timestamp
        if self._position is not None and packet.timestamp < self._position:
            self.figures.late += 1
            return
        self._waiting[packet.timestamp] = packet.payload
        if len(self._waiting) > PACKETS_LIMIT:
            del self._waiting[min(self._waiting)]

    def delay(self, now: float) -> float:
        """Seconds from the earliest arrival possible to `now`, where the sound of now is played; 0 before the first."""
        return 0.0 if self._position is None else self._delay_of(self._position - len(self._pending), now)

    def play(self, now: float) -> Block | None:
        """The block to be played now; None before the first packet's time has come."""
        if self._position is None:
            if not self._due(now):
                return None
            self._position = min(self._waiting)
        self._catch_up(now)
        while len(self._pending) < BLOCK:
            more = self._next(now)
            if more is None:
                if len(self._pending):
                    break
                more = self._made_up()
            self._pending = np.concatenate((self._pending, more))
        self._adjust(now)
        self.played_delay = self.delay(now)
        block, self._pending = self._pending[:BLOCK], self._pending[BLOCK:]
        return Block(block, self._position - len(self._pending) - len(block) + self._concealing)

    def _delay_of(self, timestamp: int, now: float) -> float:
        return now - timestamp / SAMPLE_RATE - self.target.base

    def _due(self, now: float) -> bool:
        """Whether the oldest packet that waits has its time."""
        return bool(self._waiting) and self._delay_of(min(self._waiting), now) >= self.target.seconds

    def _next(self, now: float) -> Samples | None:
        """The sound of the next packet; None if it is not there, or its time has not come."""
        if self._waiting:
            timestamp = min(self._waiting)
            if timestamp == self._position or self._due(now):
                return self._decoded(timestamp)
        return None

    def _decoded(self, timestamp: int) -> Samples:
        payload = self._waiting.pop(timestamp)
        try:
            samples = self._decoder.decode(payload)
        except UndecodableSound:
            return self._made_up()
        self._position = timestamp + len(samples)
        if self._concealing >= _SILENT:
            samples = _risen(samples)
        self._concealing = 0
        for old in [each for each in self._waiting if each < self._position]:
            del self._waiting[old]
        return samples

    def _made_up(self) -> Samples:
        if self._concealing >= _SILENT:
            samples = np.zeros((BLOCK, 2), np.int16)
        else:
            samples = _falling(self._decoder.conceal(), self._concealing)
            self.figures.concealed += len(samples)
        self._concealing += len(samples)
        return samples

    def _catch_up(self, now: float) -> None:
        """Leave out what would be played far too late."""
        while self._waiting and self.delay(now) - self.target.seconds > _ABSURD:
            timestamp = min(self._waiting)
            if len(self._waiting) == 1 or self._delay_of(timestamp, now) - self.target.seconds < _ABSURD / 2:
                return
            del self._waiting[timestamp]
            self._pending = self._pending[:0]
            self._position = min(self._waiting)
            self.figures.skipped += 1

    def _adjust(self, now: float) -> None:
        if self._concealing or self._position is None:
            return
        excess = self.delay(now) - self.target.seconds
        if excess > _ABOVE:
            self._shorten(now, excess)
        elif excess < -_BELOW:
            before = len(self._pending)
            self._pending = longer(self._pending, _PUT_IN)
            self.figures.lengthened += len(self._pending) - before

    def _shorten(self, now: float, excess: float) -> None:
        while len(self._pending) < 3 * BLOCK and self._position in self._waiting:
            self._pending = np.concatenate((self._pending, self._decoded(self._position)))
        most = min(int(excess * SAMPLE_RATE), len(self._pending) - BLOCK)
        before = len(self._pending)
        self._pending = shorter(self._pending, most, force=excess > _FAR_ABOVE)
        self.figures.shortened += before - len(self._pending)


def _falling(samples: Samples, made_up: int) -> Samples:
    """The sound, ever less loud; so many samples were made up before."""
    if made_up + len(samples) <= _LOUD:
        return samples
    left = (_SILENT - made_up - np.arange(len(samples), dtype=np.float32)) / (_SILENT - _LOUD)
    return np.asarray(np.rint(samples * np.clip(left, 0, 1)[:, np.newaxis]), np.int16)


def _risen(samples: Samples) -> Samples:
    """The sound, rising from silence."""
    ramp = np.minimum(np.arange(len(samples), dtype=np.float32) / _FADE, 1)[:, np.newaxis]
    return np.asarray(np.rint(samples * ramp), np.int16)
