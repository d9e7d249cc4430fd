import asyncio
import threading
from contextlib import AsyncExitStack

import pytest
from openrois_streaming.adaptation.demand import LOWEST, Demands
from openrois_streaming.adaptation.rung import Rung
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.publish.encoder_thread import HANG, EncoderHung
from openrois_streaming.publish.encoding import MAX_ABANDONED, Encoding
from openrois_streaming.publish.key_frames import KeyFrameCause
from openrois_streaming.publish.rendition import Rendition, WholePictures, encoded_rendition
from openrois_streaming.source.fanout import DropOldest, Fanout, SourceEnded, Subscription
from openrois_streaming.source.source import RawVideo

from tests.support.streaming import FakeEncoders, FedSource, VirtualClock, picture, settle

FRAME = 0.03


class Stage:
    """A rendition with a source, a clock and encoders in the test's hand."""

    def __init__(self, *, predicted: bool = True, fresh: float | None = None) -> None:
        self.clock = VirtualClock()
        self.source: FedSource[RawVideo] = FedSource()
        self.encoders = FakeEncoders()
        self.raw = Fanout(self.source, name="stage")
        is_fresh = None if fresh is None else lambda raw, now: now - raw.captured_at <= fresh
        encoding = Encoding("video/H264", 90_000, self.encoders, predicted, depth=1, is_fresh=is_fresh)
        self.rendition = encoded_rendition(self.raw, encoding, clock=self.clock, bitrate=1000)
        self.next = 0

    async def shoot(self, watcher: Subscription[EncodedFrame]) -> EncodedFrame:
        """Let one frame period pass and a frame be captured, and wait until `watcher` has it encoded."""
        await self.clock.advance(FRAME)
        await self.source.feed(picture(self.next, self.clock.now()))
        self.next += 1
        return await got(watcher)

    @property
    def threads(self) -> int:
        """Encoder threads that are alive."""
        return sum(thread.name == "stage video/H264" for thread in threading.enumerate())


async def got(subscription: Subscription[EncodedFrame]) -> EncodedFrame:
    async with asyncio.timeout(60):
        return await subscription.get()


@pytest.fixture
def stage() -> Stage:
    return Stage()


async def test_the_encoder_runs_from_the_first_viewer_to_the_last(stage: Stage) -> None:
    rendition = stage.rendition
    assert (rendition.running, stage.threads, stage.source.is_open) == (False, 0, False)
    async with rendition.subscribe() as first:
        await stage.shoot(first)
        await stage.clock.advance(1)
        async with rendition.subscribe() as second:
            await stage.shoot(first)
            await got(second)
            assert (rendition.running, stage.threads, len(stage.encoders.made)) == (True, 1, 1)
            assert rendition.figures().viewers == 2
    assert (rendition.running, stage.threads, stage.source.is_open) == (False, 0, False)
    assert rendition.figures().viewers == 0


async def test_a_frame_arrives_with_all_that_is_known_of_it(stage: Stage) -> None:
    async with stage.rendition.subscribe() as viewer:
        frame = await stage.shoot(viewer)
    assert frame == EncodedFrame(
        data=b"0",
        payloads=(b"0",),
        pts=round((1000 + FRAME) * 90_000),
        clock_rate=90_000,
        keyframe=True,
        sequence=0,
        captured_at=1000 + FRAME,
    )
    assert (stage.rendition.mime_type, stage.rendition.clock_rate) == ("video/H264", 90_000)


async def test_a_viewer_that_joins_gets_a_key_frame_first_and_nothing_before_it(stage: Stage) -> None:
    async with stage.rendition.subscribe() as first:
        for _ in range(5):
            await stage.shoot(first)
        async with stage.rendition.subscribe() as second:
            assert (await stage.shoot(first)).keyframe
            joined = await got(second)
            assert (joined.keyframe, joined.sequence) == (True, 5)
            assert not (await stage.shoot(first)).keyframe
            assert (await got(second)).sequence == 6
            assert second.dropped == 0


async def test_a_viewer_that_joins_gets_the_last_picture_at_once_if_it_is_fresh() -> None:
    stage = Stage(fresh=0.06)
    async with stage.rendition.subscribe() as first:
        for _ in range(5):
            await stage.shoot(first)
        await stage.clock.advance(0.05)
        async with stage.rendition.subscribe() as second:
            again = await got(second)
            assert (again.keyframe, again.data, again.sequence) == (True, b"4", 5)
            assert await got(first) == again
            assert not (await stage.shoot(first)).keyframe
            assert (await got(second)).data == b"5"
        assert (stage.rendition.figures().starts, stage.rendition.figures().dropped_input) == (2, 0)


async def test_what_runs_ahead_of_a_viewer_encodes_nothing_before_that_comes() -> None:
    stage = Stage(fresh=0.06)
    async with stage.rendition.prepare():
        for number in range(3):
            await stage.clock.advance(FRAME)
            await stage.source.feed(picture(number, stage.clock.now()))
        assert (stage.rendition.running, stage.rendition.figures().encoded) == (True, 0)
        async with stage.rendition.subscribe() as viewer:
            first = await got(viewer)
            assert (first.keyframe, first.data) == (True, b"2")
            stage.next = 3
            assert (await stage.shoot(viewer)).data == b"3"
            assert stage.encoders.made[0].encoded == [2, 3]
    assert (stage.rendition.running, stage.source.is_open) == (False, False)


async def test_a_picture_from_before_a_pause_is_never_shown_again() -> None:
    stage = Stage(fresh=0.06)
    async with stage.rendition.subscribe() as first:
        await stage.shoot(first)
        await stage.clock.advance(0.07)
        async with stage.rendition.subscribe() as second:
            assert (await stage.shoot(first)).keyframe
            assert (await got(second)).data == b"1"
    await stage.clock.advance(0.01)
    async with stage.rendition.subscribe() as third:
        await stage.shoot(third)
        assert stage.encoders.made[-1].encoded == [2], "nothing is kept while nobody watches"


@pytest.mark.parametrize("turns", range(12))
async def test_a_viewer_that_resumes_while_the_encoder_stops_gets_a_key_frame(turns: int) -> None:
    """Whatever turn of the loop it comes in: the encoder that still stops may be the one that is asked."""
    stage = Stage(fresh=0.06)
    async with AsyncExitStack() as suspended:
        viewer = await suspended.enter_async_context(stage.rendition.subscribe())
        for _ in range(5):
            await stage.shoot(viewer)
        leaving = asyncio.create_task(suspended.aclose())
        for _ in range(turns):
            await asyncio.sleep(0)
        async with stage.rendition.subscribe() as resumed:
            await leaving
            await settle()
            for number in range(5, 10):
                await stage.clock.advance(FRAME)
                await stage.source.feed(picture(number, stage.clock.now()))
            assert (await got(resumed)).keyframe


async def test_repairs_from_the_last_picture_keep_to_their_budget() -> None:
    stage = Stage(fresh=0.06)
    async with stage.rendition.subscribe() as first:
        await stage.shoot(first)
        await stage.clock.advance(0.01)
        for _ in range(20):
            stage.rendition.request_key_frame(KeyFrameCause.REPAIR)
        assert (await got(first)).keyframe
        for _ in range(3):
            assert not (await stage.shoot(first)).keyframe
            stage.rendition.request_key_frame(KeyFrameCause.REPAIR)
        assert stage.rendition.figures().repairs == 1


async def test_viewers_that_join_within_100_ms_share_a_key_frame(stage: Stage) -> None:
    async with stage.rendition.subscribe() as first:
        await stage.shoot(first)
        async with stage.rendition.subscribe() as second, stage.rendition.subscribe() as third:
            keys = [(await stage.shoot(first)).keyframe for _ in range(6)]
            assert keys == [False, False, False, True, False, False]
            assert (await got(second)).sequence == (await got(third)).sequence == 4
    assert stage.rendition.figures().starts == 2


async def test_a_key_frame_under_way_serves_the_viewer_that_joins_meanwhile(stage: Stage) -> None:
    async with stage.rendition.subscribe() as first:
        await stage.shoot(first)
        await stage.clock.advance(1)
        encoder = stage.encoders.made[0]
        async with stage.rendition.subscribe() as second:
            encoder.go_on.clear()
            await stage.source.feed(picture(1, stage.clock.now()))
            async with stage.rendition.subscribe() as third:
                encoder.go_on.set()
                assert [(await got(viewer)).keyframe for viewer in (first, second, third)] == [True] * 3
                await stage.clock.advance(1)
                assert not (await stage.shoot(first)).keyframe


async def test_repairs_are_limited_and_do_not_delay_starts(stage: Stage) -> None:
    rendition = stage.rendition
    async with rendition.subscribe() as first:
        await stage.shoot(first)
        repairs = []
        for number in range(1, 61):
            rendition.request_key_frame(KeyFrameCause.REPAIR)
            if (await stage.shoot(first)).keyframe:
                repairs.append(number)
        assert repairs == [1, 35]
        async with rendition.subscribe():
            rendition.request_key_frame(KeyFrameCause.REPAIR)
            assert (await stage.shoot(first)).keyframe
        figures = rendition.figures()
        assert (figures.key_frames, figures.starts, figures.repairs) == (4, 2, 2)


async def test_a_stalled_viewer_goes_on_at_a_key_frame_and_hurts_nobody(stage: Stage) -> None:
    async with stage.rendition.subscribe() as fast, stage.rendition.subscribe(maxsize=4) as stalled:
        keys = [(await stage.shoot(fast)).keyframe for _ in range(60)]
        assert keys == [True] + [False] * 59, "nobody reads it: no key frame is spent on it"
        assert stalled.dropped == 60
        back = asyncio.create_task(got(stalled))
        await settle()
        assert (await stage.shoot(fast)).keyframe
        assert (await back).sequence == 60
        assert not (await stage.shoot(fast)).keyframe
        assert (await got(stalled)).sequence == 61
        assert (fast.dropped, fast.delivered) == (0, 62)
    figures = stage.rendition.figures()
    assert (figures.starts, figures.repairs) == (1, 1)


async def test_sound_begins_at_once_and_loses_the_oldest() -> None:
    stage = Stage(predicted=False)
    async with stage.rendition.subscribe() as first:
        await stage.shoot(first)
        async with stage.rendition.subscribe(maxsize=2) as second:
            for _ in range(4):
                await stage.shoot(first)
            assert [(await got(second)).sequence for _ in range(2)] == [3, 4]
            assert second.dropped == 2
    assert stage.encoders.made[0].forced == []


async def test_the_failure_of_the_encoder_reaches_every_viewer_and_the_next_starts_anew(stage: Stage) -> None:
    async with stage.rendition.subscribe() as first, stage.rendition.subscribe() as second:
        await stage.shoot(first)
        await got(second)
        failure = OSError("the codec has failed")
        stage.encoders.made[0].failure = failure
        await stage.source.feed(picture(1, stage.clock.now()))
        for viewer in (first, second):
            with pytest.raises(SourceEnded) as told:
                await got(viewer)
            assert told.value.__cause__ is failure
        assert not stage.rendition.running
        async with stage.rendition.subscribe() as third:
            again = await stage.shoot(third)
            assert (again.keyframe, again.sequence) == (True, 1)
            assert len(stage.encoders.made) == 2
    assert stage.threads == 0


async def test_an_encoder_that_hangs_is_given_up_and_the_next_starts_anew(stage: Stage) -> None:
    for number in range(MAX_ABANDONED):
        async with stage.rendition.subscribe() as viewer:
            await stage.shoot(viewer)
            await stage.clock.advance(2 * HANG)
            encoder = stage.encoders.made[number]
            while encoder.entered.acquire(blocking=False):
                pass
            encoder.go_on.clear()
            await stage.source.feed(picture(100 + number, stage.clock.now()))
            assert encoder.entered.acquire(timeout=5), "its thread has the picture before time passes"
            await stage.clock.advance(HANG - 0.1)
            stage.clock.jump(100)
            await settle()
            assert stage.rendition.running
            await stage.clock.advance(HANG)
            with pytest.raises(SourceEnded) as end:
                await got(viewer)
            assert isinstance(end.value.__cause__, EncoderHung)
    assert (stage.threads, stage.source.is_open) == (MAX_ABANDONED, False)
    async with stage.rendition.subscribe() as viewer:
        with pytest.raises(SourceEnded) as end:
            await got(viewer)
        assert str(end.value.__cause__) == "3 encoders do not return"
    for encoder in stage.encoders.made:
        encoder.go_on.set()
        encoder.thread.join(5)
    async with stage.rendition.subscribe() as viewer:
        await stage.shoot(viewer)
    assert stage.threads == 0


async def test_an_encoder_that_cannot_be_made_is_told_to_the_viewer(stage: Stage) -> None:
    stage.encoders.failure = OSError("no such size")
    async with stage.rendition.subscribe() as viewer:
        with pytest.raises(SourceEnded) as told:
            await got(viewer)
        assert told.value.__cause__ is stage.encoders.failure


async def test_the_failure_of_the_source_comes_after_what_it_gave(stage: Stage) -> None:
    async with stage.rendition.subscribe() as viewer:
        await stage.shoot(viewer)
        encoder = stage.encoders.made[0]
        encoder.go_on.clear()
        await stage.source.feed(picture(1, stage.clock.now()))
        failure = ConnectionError("the game engine is gone")
        await stage.source.end(failure)
        encoder.go_on.set()
        assert (await got(viewer)).data == b"1"
        with pytest.raises(SourceEnded) as told:
            await got(viewer)
        assert told.value.__cause__ is failure


async def test_the_end_of_the_source_is_the_end_of_the_rendition(stage: Stage) -> None:
    async with stage.rendition.subscribe() as viewer:
        await stage.shoot(viewer)
        await stage.source.end()
        with pytest.raises(SourceEnded) as told:
            await got(viewer)
        assert told.value.__cause__ is None


async def test_a_fault_in_the_feeding_is_not_silent(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    async with stage.rendition.subscribe() as viewer:
        await stage.shoot(viewer)
        monkeypatch.setattr(stage.clock, "now", lambda: 1 / 0)
        await stage.source.feed(picture(1, 1001.0))
        with pytest.raises(SourceEnded) as told:
            await got(viewer)
        assert isinstance(told.value.__cause__, ZeroDivisionError)


async def test_the_bit_rate_is_kept_when_the_encoder_stops_and_starts(stage: Stage) -> None:
    async with stage.rendition.subscribe() as viewer:
        await stage.shoot(viewer)
        stage.rendition.set_bitrate(2000)
        await stage.shoot(viewer)
    stage.rendition.set_bitrate(3000)
    async with stage.rendition.subscribe() as viewer:
        await stage.shoot(viewer)
    assert [encoder.bitrate for encoder in stage.encoders.made] == [1000, 3000]
    assert stage.encoders.made[0].bitrates == [2000]
    assert stage.rendition.figures().bitrate == 3000


async def test_the_counters_go_on_when_the_encoder_stops_and_starts(stage: Stage) -> None:
    for start in (0, 3):
        async with stage.rendition.subscribe() as viewer:
            assert [(await stage.shoot(viewer)).sequence for _ in range(3)] == [start, start + 1, start + 2]
        await stage.clock.advance(1)
    figures = stage.rendition.figures()
    assert (figures.encoded, figures.encoded_bytes, figures.key_frames, figures.starts) == (6, 6, 2, 2)
    assert figures.encode_seconds > 0
    assert (figures.mime_type, figures.running) == ("video/H264", False)


async def test_frames_that_come_while_the_encoder_is_busy_are_lost_counted_and_logged_as_a_rate(
    stage: Stage, caplog: pytest.LogCaptureFixture
) -> None:
    async with stage.rendition.subscribe() as viewer:
        await stage.shoot(viewer)
        encoder = stage.encoders.made[0]
        while encoder.entered.acquire(blocking=False):
            pass
        encoder.go_on.clear()
        await stage.source.feed(picture(1, stage.clock.now()))
        assert encoder.entered.acquire(timeout=5)
        stage.rendition.request_key_frame(KeyFrameCause.REPAIR)
        for number in range(2, 12):
            stage.clock.jump(10 if number in (6, 11) else 0)
            await stage.source.feed(picture(number, stage.clock.now()))
        encoder.go_on.set()
        assert [(await got(viewer)).data for _ in range(2)] == [b"1", b"11"]
        assert encoder.forced == [0, 11], "the key frame that was asked of a lost frame passes to the next"
        assert stage.rendition.figures().dropped_input == 9
        assert [record.message for record in caplog.records] == [
            "stage video/H264: lost 4 raw frames in 10 s",
            "stage video/H264: lost 5 raw frames in 10 s",
        ]
        stage.next = 12
        await stage.clock.advance(20)
        await stage.shoot(viewer)
        assert len(caplog.records) == 2, "an interval without losses is not mentioned"
    assert stage.rendition.figures().dropped_input == 9


def frame(sequence: int, *, keyframe: bool = False) -> EncodedFrame:
    return EncodedFrame(b"", (), sequence, 90_000, keyframe, sequence, 0.0)


def test_the_mailbox_of_a_viewer_counts_what_it_loses_and_asks_when_it_is_read_again() -> None:
    asked = []
    mailbox = WholePictures(3, lambda: asked.append(1))
    mailbox.awaited()
    assert [mailbox.put(frame(0)), len(mailbox)] == [0, 0]
    assert [mailbox.put(frame(number, keyframe=number == 1)) for number in range(1, 4)] == [0, 0, 0]
    assert [mailbox.put(frame(4)), len(mailbox)] == [4, 0]
    assert [mailbox.put(frame(5)), len(mailbox), asked] == [1, 0, []]
    mailbox.awaited()
    assert asked == [1]
    assert mailbox.put(frame(6, keyframe=True)) == 0
    assert mailbox.take().sequence == 6
    mailbox.awaited()
    assert asked == [1]


def test_a_key_frame_takes_the_place_of_a_full_mailbox_and_joins_another() -> None:
    mailbox = WholePictures(2, lambda: pytest.fail("nothing is broken"))
    mailbox.put(frame(0, keyframe=True))
    assert mailbox.put(frame(1, keyframe=True)) == 0
    assert [mailbox.put(frame(2, keyframe=True)), len(mailbox)] == [2, 1]
    assert mailbox.put(frame(3)) == 0
    assert [mailbox.take().sequence, mailbox.take().sequence] == [2, 3]


def test_a_mailbox_of_pictures_holds_at_least_one() -> None:
    with pytest.raises(ValueError, match="at least one"):
        WholePictures(0, lambda: None)
    assert len(DropOldest[int](1)) == 0


async def test_a_viewer_that_leaves_while_it_waits_leaves_nothing_behind(stage: Stage) -> None:
    async def watch() -> None:
        async with stage.rendition.subscribe() as viewer:
            await viewer.get()

    watching = asyncio.create_task(watch())
    await settle()
    assert stage.rendition.running
    watching.cancel()
    with pytest.raises(asyncio.CancelledError):
        await watching
    assert (stage.rendition.running, stage.threads, stage.source.is_open) == (False, 0, False)


RUNG = Rung(160, 90, 30.0, 50_000, 200_000)


def laddered(mime_type: str = "video/H264") -> tuple[Stage, Rendition]:
    stage = Stage()
    encoding = Encoding(mime_type, 90_000, stage.encoders, predicted=True, depth=1)
    demands = Demands(RUNG, LOWEST)
    return stage, encoded_rendition(stage.raw, encoding, clock=stage.clock, bitrate=RUNG.max_bitrate, demands=demands)


async def test_who_plays_it_takes_each_frame_at_once_and_says_what_it_can_take() -> None:
    stage, rendition = laddered()
    taken: list[EncodedFrame] = []
    assert (rendition.rung, rendition.was_played) == (RUNG, False)
    async with rendition.play("me", taken.append, 150_000), rendition.subscribe() as watcher:
        first = await stage.shoot(watcher)
        assert taken == [first]
        assert stage.encoders.made[0].bitrate == 150_000
        rendition.demand("me", 148_000)
        rendition.demand("me", 100_000)
        await stage.shoot(watcher)
        assert stage.encoders.made[0].bitrates == [100_000], "what is hardly another rate is none"
        assert (rendition.least("me"), rendition.figures().size) == (50_000, "160x90@30")
        async with rendition.play("other", lambda _: None, 60_000):
            await stage.shoot(watcher)
        await stage.shoot(watcher)
        assert stage.encoders.made[0].bitrates == [100_000, 60_000, 100_000]
    assert (rendition.running, rendition.was_played, len(taken)) == (False, True, 4)


async def test_a_viewer_that_cannot_take_a_frame_hurts_no_other(caplog: pytest.LogCaptureFixture) -> None:
    stage, rendition = laddered()

    def fail(_: EncodedFrame) -> None:
        raise ValueError("odd")

    async with rendition.play("odd", fail, 150_000), rendition.subscribe() as watcher:
        await stage.shoot(watcher)
        await stage.shoot(watcher)
        assert rendition.running
    assert [record.message for record in caplog.records].count("a viewer could not take a frame") == 2


async def test_who_plays_it_hears_of_its_end() -> None:
    stage, rendition = laddered()
    async with rendition.play("me", lambda _: None, 150_000) as playing:
        await stage.source.end(OSError("unplugged"))
        with pytest.raises(SourceEnded) as told:
            await got(playing)
        assert isinstance(told.value.__cause__, OSError)


async def test_a_codec_that_begins_anew_for_another_rate_changes_in_steps() -> None:
    stage, rendition = laddered("video/VP8")
    async with rendition.play("me", lambda _: None, 200_000), rendition.subscribe() as watcher:
        for bitrate in (190_000, 180_000, 165_000, 120_000):
            rendition.demand("me", bitrate)
            await stage.shoot(watcher)
        assert (stage.encoders.made[0].bitrate, stage.encoders.made[0].bitrates) == (160_000, [102_400])


async def test_a_source_of_another_size_has_other_bounds() -> None:
    stage, rendition = laddered()
    async with rendition.play("me", lambda _: None, 500_000), rendition.subscribe() as watcher:
        await stage.shoot(watcher)
        rendition.suit(RUNG, LOWEST)
        rendition.suit(Rung(320, 180, 30.0, 50_000, 300_000), LOWEST)
        await stage.shoot(watcher)
        assert stage.encoders.made[0].bitrates == [300_000]


async def test_frames_that_are_not_chosen_are_not_encoded() -> None:
    stage = Stage()
    encoding = Encoding(
        "video/H264", 90_000, stage.encoders, predicted=True, depth=1, choose=lambda raw: raw.sequence % 2 == 0
    )
    rendition = encoded_rendition(stage.raw, encoding, clock=stage.clock, bitrate=1000)
    async with rendition.subscribe() as viewer:
        for number in range(4):
            await stage.source.feed(picture(number, stage.clock.now()))
            if number % 2 == 0:
                await got(viewer)
        assert stage.encoders.made[0].encoded == [0, 2]
        assert rendition.figures().dropped_input == 0


async def test_sound_is_played_by_whoever_wants_it() -> None:
    stage = Stage(predicted=False)
    assert (stage.rendition.rung, stage.rendition.least("me")) == (None, 0.0)
    taken: list[EncodedFrame] = []
    async with stage.rendition.play("me", taken.append), stage.rendition.subscribe() as watcher:
        stage.rendition.demand("me", 1.0)
        stage.rendition.suit(RUNG, LOWEST)
        await stage.shoot(watcher)
    assert len(taken) == 1
    assert stage.rendition.figures().size == ""
