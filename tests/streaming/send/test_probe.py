import pytest
from openrois_streaming.send.probe import MOST_SECONDS, Probe

from tests.support.sending import Alarms
from tests.support.streaming import VirtualClock


class Path:
    """What leaves for a viewer."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.alarms = Alarms(self.clock)
        self.left = 5_000
        self.padded = 0
        self.dry = False

    def pad(self, octets: int) -> int:
        sent = 0 if self.dry else octets
        self.padded += sent
        self.left += sent
        return sent

    def probe(self, bitrate: int, seconds: float) -> Probe:
        return Probe(
            bitrate,
            seconds,
            pad=self.pad,
            left=lambda: self.left,
            now=self.clock.now,
            later=self.alarms.later,
        )


def test_it_brings_what_leaves_up_to_the_rate() -> None:
    path = Path()
    path.probe(800_000, 0.5)
    path.alarms.advance(2.0)
    assert path.padded == pytest.approx(50_000, abs=1000)
    assert path.alarms.pending == []


def test_media_counts() -> None:
    path = Path()
    path.probe(800_000, 0.5)
    for _ in range(50):
        path.left += 600
        path.alarms.advance(0.01)
    assert path.padded == pytest.approx(50_000 - 30_000, abs=1000)


def test_it_does_not_go_on_for_long_nor_when_there_is_nothing_to_pad_with() -> None:
    path = Path()
    path.probe(800_000, 60.0)
    path.alarms.advance(MOST_SECONDS + 0.1)
    assert path.alarms.pending == []
    path.dry = True
    path.probe(800_000, 0.5)
    path.alarms.advance(0.05)
    assert path.alarms.pending == []


def test_it_can_be_stopped() -> None:
    path = Path()
    path.probe(800_000, 0.5).stop()
    path.alarms.advance(0.5)
    assert path.padded == 0
