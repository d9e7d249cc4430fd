"""A microphone, a path and a listener on a clock that tests turn by hand: what a playout buffer makes of a path."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from openrois_streaming.receive.playout import BLOCK, Block, Playout, SoundPacket, UndecodableSound
from openrois_streaming.receive.stretch import Samples

PACKET = 960
PACKET_SECONDS = PACKET / 48_000
ORIGIN = 1 << 33


def hum(timestamp: int, samples: int) -> Samples:
    """A voiced sound: 200 Hz with overtones, stereo."""
    time = (timestamp + np.arange(samples)) / 48_000
    wave = sum(np.sin(2 * math.pi * 200 * part * time) / part for part in (1, 2, 3))
    return np.repeat(np.asarray(6000 * wave, np.int16)[:, np.newaxis], 2, axis=1)


class FakeOpus:
    """Packets say which part of the hum they hold; what is concealed is all 100."""

    def decode(self, payload: bytes) -> Samples:
        if payload == b"bad":
            raise UndecodableSound
        return hum(int(payload), PACKET)

    def conceal(self) -> Samples:
        return np.full((BLOCK, 2), 100, np.int16)


@dataclass
class Hearing:
    """What a listener got: each block with its time, and with the delay from its capture."""

    playout: Playout
    blocks: list[tuple[float, Block]] = field(default_factory=list)

    def delays(self, since: float, until: float = math.inf) -> list[float]:
        """Seconds from a block's capture to its playing, of those that were played in that time."""
        return [now - (block.timestamp - ORIGIN) / 48_000 for now, block in self.blocks if since <= now < until]

    def median(self, since: float, until: float = math.inf) -> float:
        return float(np.median(self.delays(since, until)))


def listen(
    arrivals: Iterable[tuple[float, int, bytes]], seconds: float, *, begin: float = 0.0, playout: Playout | None = None
) -> Hearing:
    """Play for `seconds`; `arrivals` are (arrival, timestamp from 0 on, payload)."""
    hearing = Hearing(playout or Playout(FakeOpus()))
    coming = sorted(arrivals)
    now = begin
    while now < begin + seconds:
        while coming and coming[0][0] <= now:
            arrival, timestamp, payload = coming.pop(0)
            hearing.playout.add(SoundPacket(ORIGIN + timestamp, payload), arrival)
        block = hearing.playout.play(now)
        if block is not None:
            assert 0 < len(block.samples) <= BLOCK
            hearing.blocks.append((now, block))
            now += len(block.samples) / 48_000
        else:
            now += 0.001
    return hearing


def microphone(
    seconds: float,
    delay: Callable[[int], float | None] = lambda number: 0.0,
    *,
    drift: float = 0.0,
) -> list[tuple[float, int, bytes]]:
    """Packets of the hum, each `delay` seconds late, None for lost; its clock runs `drift` too fast (1e-6 = 1 ppm)."""
    sent = []
    for number in range(int(seconds / PACKET_SECONDS)):
        late = delay(number)
        if late is not None:
            captured = (number + 1) * PACKET_SECONDS * (1 - drift)
            sent.append((captured + late, number * PACKET, b"%d" % (number * PACKET)))
    return sent
