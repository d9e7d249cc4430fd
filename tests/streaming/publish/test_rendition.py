"""A rendition: when its encoder runs, its failures, counters and bit rate."""

import asyncio

import pytest
from openrois_streaming.adaptation.demand import LOWEST, Demands
from openrois_streaming.adaptation.rung import Rung
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.publish.encoder_thread import HANG, EncoderHung
from openrois_streaming.publish.encoding import MAX_ABANDONED, Encoding
from openrois_streaming.publish.key_frames import KeyFrameCause
from openrois_streaming.publish.rendition import Rendition, encoded_rendition
from openrois_streaming.source.fanout import SourceEnded

from tests.support.rendition_stage import FRAME, Stage, got
from tests.support.streaming import picture, settle


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


async def test_encoder_run_ahead_encodes_nothing_before_a_viewer() -> None:
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
        assert str(end.value.__cause__) == "3 encoders hang: restart the adapter"
    for encoder in stage.encoders.made:
        encoder.go_on.set()
        encoder.thread.join(5)
    async with stage.rendition.subscribe() as viewer:
        await stage.shoot(viewer)
    assert stage.threads == 0


async def test_encoder_that_cannot_be_made_ends_the_subscription(stage: Stage) -> None:
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


async def test_playing_viewer_gets_each_frame_at_once_and_sets_its_demand() -> None:
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
    assert [record.message for record in caplog.records].count("a frame could not be passed to a viewer") == 2


async def test_playing_viewer_is_notified_of_the_end() -> None:
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


async def test_sound_is_played_by_every_viewer() -> None:
    stage = Stage(predicted=False)
    assert (stage.rendition.rung, stage.rendition.least("me")) == (None, 0.0)
    taken: list[EncodedFrame] = []
    async with stage.rendition.play("me", taken.append), stage.rendition.subscribe() as watcher:
        stage.rendition.demand("me", 1.0)
        stage.rendition.suit(RUNG, LOWEST)
        await stage.shoot(watcher)
    assert len(taken) == 1
    assert stage.rendition.figures().size == ""
