"""Playout of sound packets without a break, with late, lost and superfluous ones concealed. Pure."""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from openrois_streaming.receive.jitter import TargetDelay
from openrois_streaming.receive.stretch import Samples, longer, shorter
from openrois_streaming.source.source import SAMPLE_RATE

BLOCK = SAMPLE_RATE // 100
"""Samples that are played at a time, unless more are asked for: 10 ms."""

PACKETS_LIMIT = 128
"""Limit on packets that wait to be played."""

# Excess of the delay above which sound is shortened, and shortage below which it is lengthened. Together they exceed
# one insertion, so that it is not taken out again.
_ABOVE, _BELOW = 0.008, 0.001
_PUT_IN = round(0.0075 * SAMPLE_RATE)
# Excess above which sound is shortened even where it is neither periodic nor quiet, and whole packets are skipped.
_FAR_ABOVE, _ABSURD = 0.03, 0.1
# Concealed samples at full loudness, and the number after which there is silence.
_LOUD, _SILENT = round(0.04 * SAMPLE_RATE), round(0.24 * SAMPLE_RATE)
_FADE = SAMPLE_RATE // 200


class SoundDecoder(Protocol):
    """Decoder of the packets of one source in their order, in stereo."""

    def decode(self, payload: bytes) -> Samples:
        """Decode a packet.

        Raises:
            UndecodableSound: it cannot be decoded.
        """
        ...

    def conceal(self) -> Samples:
        """Return a block that continues the sound before it."""
        ...


class UndecodableSound(ValueError):
    """Packet that cannot be decoded into sound."""


class SoundPacket(NamedTuple):
    """Sound packet; `timestamp` is unwrapped, in samples."""

    timestamp: int
    payload: bytes


class Block(NamedTuple):
    """Block of sound, and the timestamp of its first one."""

    samples: Samples
    timestamp: int


@dataclass
class PlayoutFigures:
    """Counts of changes to the sound, in samples, or packets where noted."""

    concealed: int = 0
    shortened: int = 0
    lengthened: int = 0
    late: int = 0
    """Packets that came too late."""
    skipped: int = 0
    """Packets that were skipped to catch up."""


class Playout:
    """Playout buffer of one source.

    `add` queues packets when they arrive. `play` is called whenever the block before is over: a block ends with its
    packet if the next one may still be missing. A packet is played after the delay of `TargetDelay`. If the delay is
    higher, periods of the sound are left out; if it has to rise, some are repeated.

    A block has `longest` samples at most, `BLOCK` or more. Longer ones cost less, and do not wait for a further packet.
    """

    def __init__(self, decoder: SoundDecoder, longest: int = BLOCK) -> None:
        self.figures = PlayoutFigures()
        self.target = TargetDelay()
        self.played_delay = 0.0
        """Delay of the last played block, in seconds."""
        self._decoder = decoder
        self._longest = longest
        self._waiting: dict[int, bytes] = {}
        self._pending: Samples = np.empty((0, 2), np.int16)
        self._position: int | None = None
        """Timestamp behind the last decoded sample."""
        self._concealing = 0
        """Samples concealed since the last decoded ones."""

    def add(self, packet: SoundPacket, arrival: float) -> None:
        """Add a packet that came at `arrival` (seconds)."""
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
        """Return the seconds from the earliest possible arrival of the present sound to `now`; 0 before the first."""
        return 0.0 if self._position is None else self._delay_of(self._position - len(self._pending), now)

    def play(self, now: float) -> Block | None:
        """Return the block to be played now; None before the first packet is due."""
        if self._position is None:
            if not self._due(now):
                return None
            self._position = min(self._waiting)
        self._catch_up(now)
        while len(self._pending) < self._longest:
            more = self._next(now)
            if more is None:
                if len(self._pending):
                    break
                more = self._made_up()
            self._pending = np.concatenate((self._pending, more)) if len(self._pending) else more
        self._adjust(now)
        self.played_delay = self.delay(now)
        block, self._pending = self._pending[: self._longest], self._pending[self._longest :]
        return Block(block, self._position - len(self._pending) - len(block) + self._concealing)

    def _delay_of(self, timestamp: int, now: float) -> float:
        return now - timestamp / SAMPLE_RATE - self.target.base

    def _due(self, now: float) -> bool:
        """Tell whether the oldest waiting packet is due."""
        return bool(self._waiting) and self._delay_of(min(self._waiting), now) >= self.target.seconds

    def _next(self, now: float) -> Samples | None:
        """Return the sound of the next packet; None if it is missing or not due."""
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
        """Skip packets that would be played far too late."""
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
    """Return the sound, fading out; so many samples were concealed before."""
    if made_up + len(samples) <= _LOUD:
        return samples
    left = (_SILENT - made_up - np.arange(len(samples), dtype=np.float32)) / (_SILENT - _LOUD)
    return np.asarray(np.rint(samples * np.clip(left, 0, 1)[:, np.newaxis]), np.int16)


def _risen(samples: Samples) -> Samples:
    """Return the sound, fading in from silence."""
    ramp = np.minimum(np.arange(len(samples), dtype=np.float32) / _FADE, 1)[:, np.newaxis]
    return np.asarray(np.rint(samples * ramp), np.int16)
