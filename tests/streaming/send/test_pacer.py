from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.rtp.payloads import PAYLOAD_LIMIT
from openrois_streaming.send.pacer import (
    BURST,
    LEAST_RATE,
    LONGEST_BACKLOG,
    MOST_RATE,
    Pacer,
)

from tests.support.sending import Alarms
from tests.support.streaming import VirtualClock


def frame(sequence: int, packets: int, *, keyframe: bool = False) -> EncodedFrame:
    payloads = (bytes(PAYLOAD_LIMIT),) * packets
    return EncodedFrame(b"".join(payloads), payloads, 0, 90_000, keyframe, sequence, 0.0)


class Source:
    """A sender, as its pacer sees it."""

    def __init__(self) -> None:
        self.released: list[tuple[int, int, int]] = []
        self.discarded: list[tuple[int, bool]] = []

    def release(self, frame: EncodedFrame, first: int, end: int) -> None:
        self.released.append((frame.sequence, first, end))

    def discard(self, frames: int, *, repair: bool) -> None:
        self.discarded.append((frames, repair))

    @property
    def packets(self) -> int:
        return sum(end - first for _, first, end in self.released)


class Pacing:
    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.alarms = Alarms(self.clock)
        self.pacer = Pacer(self.clock, self.alarms.later)
        self.source = Source()

    def send(self, *frames: EncodedFrame) -> None:
        for each in frames:
            self.pacer.send(self.source, each, urgent=False)


def test_an_ordinary_picture_leaves_whole_and_at_once() -> None:
    pacing = Pacing()
    pacing.send(frame(0, 8))
    assert pacing.source.released == [(0, 0, 8)]
    assert (pacing.pacer.backlog, pacing.alarms.pending) == (0, [])


def test_a_large_picture_is_spread_out() -> None:
    pacing = Pacing()
    pacing.pacer.rate = 5_000_000
    pacing.send(frame(0, 100, keyframe=True))
    assert pacing.source.packets == BURST // PAYLOAD_LIMIT
    seconds = 0
    while pacing.source.packets < 100:
        before = pacing.source.packets
        pacing.alarms.advance(0.01)
        assert pacing.source.packets - before <= 5_000_000 / 8 * 0.01 / PAYLOAD_LIMIT + 2
        seconds += 1
    assert 14 <= seconds <= 17, "83 packets of 1,172 bytes at 5 Mbit/s"
    assert [end for _, _, end in pacing.source.released[:-1]] == [first for _, first, _ in pacing.source.released[1:]]
    assert pacing.alarms.pending == []


def test_packets_behind_a_large_picture_wait_but_sound_does_not() -> None:
    pacing, sound = Pacing(), Source()
    pacing.send(frame(0, 40), frame(1, 2))
    pacing.pacer.send(sound, frame(7, 1), urgent=True)
    assert sound.released == [(7, 0, 1)]
    assert {sequence for sequence, _, _ in pacing.source.released} == {0}
    pacing.alarms.advance(0.1)
    assert pacing.source.released[-1][::2] == (1, 2)
    assert pacing.source.packets == 42


def test_late_pictures_are_dropped_unless_begun() -> None:
    pacing = Pacing()
    pacing.pacer.rate = LEAST_RATE
    pacing.send(frame(0, 200))
    sent = 1
    while not pacing.source.discarded:
        pacing.send(frame(sent, 40))
        sent += 1
    assert pacing.source.discarded == [(sent - 1, True)]
    assert pacing.pacer.backlog > 0
    pacing.alarms.advance(1.0)
    assert {sequence for sequence, _, _ in pacing.source.released} == {0}
    assert pacing.source.packets == 200


def test_a_key_frame_takes_the_place_of_what_is_too_late() -> None:
    pacing = Pacing()
    pacing.pacer.rate = LEAST_RATE
    pacing.send(frame(0, 200), frame(1, 200))
    assert pacing.pacer.backlog > LONGEST_BACKLOG
    pacing.send(frame(2, 20, keyframe=True))
    assert pacing.source.discarded == [(1, False)]
    pacing.alarms.advance(1.0)
    assert {sequence for sequence, _, _ in pacing.source.released} == {0, 2}


def test_another_sources_pictures_are_let_be() -> None:
    pacing, other = Pacing(), Source()
    pacing.pacer.rate = LEAST_RATE
    pacing.send(frame(0, 200), frame(1, 200))
    pacing.pacer.send(other, frame(2, 1), urgent=False)
    assert (pacing.source.discarded, other.discarded) == ([], [(1, True)])
    pacing.alarms.advance(1.0)
    assert (pacing.source.packets, other.packets) == (400, 0)


def test_the_pace_follows_the_path_within_bounds() -> None:
    pacing = Pacing()
    for bitrate, rate in ((1, LEAST_RATE), (4_000_000, 10_000_000), (10**9, MOST_RATE)):
        pacing.pacer.estimated(bitrate)
        assert pacing.pacer.rate == rate


def test_repetitions_take_from_what_pictures_may_have() -> None:
    pacing = Pacing()
    pacing.pacer.spend(BURST + 10_000)
    pacing.send(frame(0, 5))
    assert pacing.source.released == []
    pacing.alarms.advance(0.1)
    assert pacing.source.packets == 5


def test_a_closed_pacer_has_nothing_left() -> None:
    pacing = Pacing()
    pacing.send(frame(0, 100))
    pacing.pacer.close()
    assert (pacing.alarms.pending, pacing.pacer.backlog) == ([], 0)
