"""Media of an application: real gateway, real adapter, real WebRTC."""

import asyncio
import io
import threading
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from types import SimpleNamespace

import av
import numpy as np
import pytest
from openrois_media import Media
from openrois_media.client.media import _is_new
from openrois_media.client.readers import Block, Frame
from openrois_streaming.clock import SystemClock
from openrois_streaming.source import stamp
from openrois_streaming.source.source import RawVideo
from openrois_streaming.synthetic import ColourBars, Tone

from openrois.client import Client, Unsupported
from openrois.client.components import AudioStreaming, VideoStreaming
from openrois.types.codes import StreamStatus
from tests.support.loopback import PATIENCE
from tests.support.media_body import CAMERA, MICROPHONE, Body, application, body, read
from tests.support.streaming import FedSource

pytestmark = pytest.mark.media


@pytest.fixture
async def robot() -> AsyncIterator[Body]:
    async with body() as one:
        yield one


async def until(so: Callable[[], object]) -> None:
    """Wait for what is not announced."""
    async with asyncio.timeout(PATIENCE):
        while not so():  # noqa: ASYNC110 - see above
            await asyncio.sleep(0.01)


async def number(reader: AsyncIterator[Frame]) -> int:
    """Return the number that the next picture bears."""
    (frame,) = await read(reader)
    picture = stamp.read(frame.data[: frame.height])
    assert picture is not None
    return picture.number


async def test_pictures_are_arrays_with_their_capture_time(robot: Body) -> None:
    async with application(robot) as (client, media):
        camera = await client.find(VideoStreaming)
        async with media.frames(camera) as colours, media.frames(CAMERA, "i420") as planes:
            frames = await read(colours, 5)
            assert all(frame.data.shape == (180, 320, 3) for frame in frames)
            assert {frame.format for frame in frames} == {"rgb24"}
            assert colours.component_ref == CAMERA
            while (frame := (await read(planes))[0]).captured_at is None:
                pass
            assert frame.data.shape == (270, 320)
            shown = stamp.read(frame.data[:180])
            assert shown is not None
            assert shown.age(frame.captured_at) == pytest.approx(0, abs=0.05)
            assert 0 <= time.monotonic() - frame.local_time < PATIENCE
            assert len(robot.session.stream_ids) == 1, "two readers share one stream"
            assert sum(thread.name == "decode video" for thread in threading.enumerate()) == 1


async def test_colours_are_those_of_the_source(robot: Body) -> None:
    async with application(robot) as (_, media), media.frames(CAMERA) as rgb, media.frames(CAMERA, "bgr24") as bgr:
        (first,), (second,) = await read(rgb), await read(bgr)
        # The first bar of eight is grey, the third one is cyan.
        cyan = first.data[20, 320 * 5 // 16]
        assert int(cyan[0]) < 60 < int(cyan[1])
        assert np.abs(second.data[20, 320 * 5 // 16, ::-1].astype(int) - cyan).max() < 12


async def test_sound_comes_in_blocks(robot: Body) -> None:
    async with application(robot) as (client, media), media.blocks(await client.find(AudioStreaming)) as blocks:
        heard: list[Block] = []
        while not heard or heard[-1].captured_at is None:
            heard += await read(blocks)
        assert all(block.samples.dtype == np.int16 and block.samples.shape[1] == 2 for block in heard)
        assert abs(time.time() - heard[-1].captured_at) < 5
        assert time.monotonic() - heard[-1].local_time < 5
        heard += await read(blocks, 200)
        assert max(np.abs(block.samples).max() for block in heard) > 1000


async def test_a_slow_reader_gets_the_newest_picture(robot: Body) -> None:
    async with (
        application(robot) as (_, media),
        media.frames(CAMERA, "i420") as quick,
        media.frames(CAMERA, "i420") as slow,
    ):
        before = await number(slow)
        for _ in range(10):
            newest = await number(quick)
        assert before < newest
        assert newest <= await number(slow)
        assert slow.dropped > 0


async def test_nothing_is_decoded_without_a_reader_and_the_last_one_ends_the_stream(robot: Body) -> None:
    async with application(robot) as (_, media):
        async with media.frames(CAMERA) as one:
            async with media.frames(CAMERA) as two:
                await read(two)
            await read(one)
            assert len(robot.session.stream_ids) == 1
        assert robot.session.stream_ids == ()
        assert not [each for each in threading.enumerate() if each.name == "decode video"]
        async with media.frames(CAMERA) as again:
            await read(again)


async def test_suspended_and_resumed(robot: Body) -> None:
    async with application(robot) as (_, media), media.frames(CAMERA) as one, media.frames(CAMERA) as other:
        await read(one)
        await read(other)
        await one.suspend()
        await read(other, 3)
        (stream_id,) = robot.session.stream_ids
        await until(lambda: other.status is StreamStatus.STREAMING_RUNNING)
        await other.suspend()
        await until(lambda: other.status is StreamStatus.STREAMING_SUSPENDED)
        sent = (await robot.session.stats(stream_id)).frames_sent
        resumed_at = time.monotonic()
        await one.resume()
        (frame,) = await read(one)
        assert frame.local_time >= resumed_at
        assert (await robot.session.stats(stream_id)).frames_sent > sent
        await until(lambda: one.status is StreamStatus.STREAMING_RUNNING)
        assert robot.session.stream_ids == (stream_id,)


async def restart(robot: Body, client: Client) -> None:
    """The engine replaces the peer connection."""
    await client.call("signaling.restart", peer_id=robot.session.peer_ids[0])


async def end_peer(robot: Body, _client: Client) -> None:
    """The engine says goodbye."""
    robot.session.end_peer(robot.session.peer_ids[0], "for a test")


async def cut_off(robot: Body, _client: Client) -> None:
    """The connection to the gateway is lost."""
    robot.relay.cut()


async def replace_adapter(robot: Body, _client: Client) -> None:
    """The adapter dies, and another one takes its place."""
    await robot.kill()
    await robot.start()


@pytest.mark.parametrize("fault", [restart, end_peer, cut_off, replace_adapter])
async def test_pictures_and_sound_go_on_after(robot: Body, fault: Callable[[Body, Client], Awaitable[None]]) -> None:
    async with (
        application(robot) as (client, media),
        media.frames(CAMERA) as frames,
        media.blocks(MICROPHONE) as blocks,
    ):
        await read(frames, 3)
        await read(blocks, 3)
        (before,) = robot.sessions
        peers = before.peer_ids
        await fault(robot, client)

        def moved() -> bool:
            return any(set(each.peer_ids) - set(peers) for each in robot.sessions)

        while not moved():
            await read(blocks)
        at = time.monotonic()
        frame = (await read(frames))[0]
        while frame.local_time < at:
            frame = (await read(frames))[0]
        await read(blocks, 10)
        await until(lambda: frames.status is StreamStatus.STREAMING_RUNNING)
        assert frames.problem == ""


async def test_a_suspended_stream_comes_back_suspended(robot: Body) -> None:
    async with application(robot) as (_, media), media.frames(CAMERA) as frames:
        await read(frames)
        await frames.suspend()
        await replace_adapter(robot, None)  # type: ignore[arg-type]
        await until(lambda: frames.status is StreamStatus.STREAMING_SUSPENDED and robot.sessions)
        await frames.resume()
        await read(frames, 3)


async def test_a_snapshot_is_a_jpeg_or_an_array(robot: Body) -> None:
    async with application(robot) as (_, media):
        file = await media.snapshot(CAMERA)
        with av.open(io.BytesIO(file), "r", format="mjpeg") as opened:
            (picture,) = opened.decode(video=0)
        assert (picture.width, picture.height) == (320, 180)
        shown = stamp.read(np.asarray(picture.to_ndarray(format="gray"), np.uint8))
        assert shown is not None
        assert 0 <= shown.age(time.time()) < PATIENCE
        assert (await media.snapshot(CAMERA, "bgr24")).shape == (180, 320, 3)
        assert robot.session.stream_ids == ()


async def test_a_snapshot_says_why_there_is_none(robot: Body) -> None:
    robot.picture.running.clear()
    async with application(robot) as (_, media):
        with pytest.raises(TimeoutError, match=rf"{CAMERA} gave no picture within 2 s: its stream is STREAMING_"):
            await media.snapshot(CAMERA, timeout=2)
    robot.picture.running.set()


async def test_old_pictures_are_no_snapshots(robot: Body) -> None:
    # A report that a busy machine hands over late makes pictures younger by as much.
    robot.picture.delay = 2.0
    async with application(robot) as (_, media), media.frames(CAMERA) as frames:
        (frame,) = await read(frames)
        while frame.captured_at is None:
            (frame,) = await read(frames)
        with pytest.raises(TimeoutError, match="gave no picture within 1 s"):
            await media.snapshot(CAMERA, timeout=1)


async def test_a_snapshot_of_a_new_stream_waits_for_the_clock_of_its_sender(robot: Body) -> None:
    async with application(robot) as (_, media):
        frame = await media.new_frame(CAMERA)
        assert frame.captured_at is not None
        assert frame.data.shape == (180, 320, 3)


@pytest.mark.parametrize(
    ("reported_at", "age", "clock_until", "is_new"),
    [
        (5.0, 0.9, 110.0, True),
        (5.0, 1.1, 110.0, False),
        (None, 0.0, 110.0, False),
        (None, 0.9, 100.0, True),
        (None, 1.1, 100.0, False),
    ],
)
def test_a_snapshot_is_new_by_the_clock_of_its_sender_if_that_is_told_in_time(
    reported_at: float | None, age: float, clock_until: float, is_new: bool
) -> None:
    picture = SimpleNamespace(reported_at=reported_at, captured_at=100.0 - age)
    assert _is_new(picture, 100.0, clock_until) is is_new  # type: ignore[arg-type]


async def test_what_is_not_there_is_refused(robot: Body) -> None:
    async with application(robot) as (client, media):
        with pytest.raises(Unsupported, match="there is no component robot/other"):
            async with media.frames("robot/other"):
                pass
        with pytest.raises(ValueError, match=rf"{MICROPHONE} has audio, not video: use media\.blocks"):
            await media.snapshot(MICROPHONE)
        with pytest.raises(ValueError, match=r"use media\.frames"):
            async with media.blocks(client.component(VideoStreaming, CAMERA)):
                pass
        with pytest.raises(ValueError, match="'gray' is not a format of pictures"):
            async with media.frames(CAMERA, "gray"):  # type: ignore[arg-type]
                pass
        with pytest.raises(ValueError, match="'png' is not a format of snapshots"):
            await media.snapshot(CAMERA, "png")  # type: ignore[call-overload]
        closed = Media(client)
        with pytest.raises(RuntimeError, match="async with Media"):
            await closed.snapshot(CAMERA)


async def test_camera_and_microphone_of_the_application_arrive(robot: Body) -> None:
    clock = SystemClock()
    async with (
        application(robot) as (_, media),
        robot.screen.subscribe(1) as screen,
        robot.speaker.subscribe(1) as speaker,
        media.send(camera=ColourBars(160, 120, 15, clock=clock), microphone=Tone(clock=clock)) as sending,
    ):
        assert set(sending.component_refs) == {CAMERA, MICROPHONE}
        async with asyncio.timeout(PATIENCE):
            picture, _ = await screen.get(), await speaker.get()
        assert (picture.width, picture.height) == (160, 120)
        await sending.suspend()
        await until(lambda: sending.status[CAMERA] is StreamStatus.STREAMING_SUSPENDED)
        await sending.resume()
        await until(lambda: sending.status[CAMERA] is StreamStatus.STREAMING_RUNNING)
        await replace_adapter(robot, None)  # type: ignore[arg-type]
        async with asyncio.timeout(PATIENCE):
            await speaker.get()
            await screen.get()
        await until(lambda: sending.problem == "")
    assert not [each for session in robot.streams.sessions for each in session.stream_ids]


async def test_the_end_and_the_failure_of_what_is_sent(robot: Body) -> None:
    async with application(robot) as (_, media):
        ending, failing = FedSource[RawVideo](), FedSource[RawVideo]()
        async with media.send(camera=ending, to=MICROPHONE) as sending:
            await ending.end()
            async with asyncio.timeout(PATIENCE):
                await sending.finished()
        async with media.send(camera=failing, to=CAMERA) as sending:
            await failing.end(OSError("the cable is out"))
            async with asyncio.timeout(PATIENCE):
                with pytest.raises(OSError, match="the cable is out"):
                    await sending.finished()
        with pytest.raises(ValueError, match="nothing to send"):
            async with media.send():
                pass
        with pytest.raises(TypeError, match=r"camera is a int and no source: use opencv_camera, v4l2_camera or ffmpeg"):
            async with media.send(camera=0, to=CAMERA):  # type: ignore[arg-type]
                pass
        with pytest.raises(Unsupported, match="no component of other/arm takes the video"):
            async with media.send(camera=ending, to="other/arm"):
                pass


async def test_nothing_is_left_behind(robot: Body) -> None:
    tasks, threads = asyncio.all_tasks(), threading.active_count()
    async with Client(robot.url) as client:
        async with Media(client) as media, media.frames(CAMERA) as frames, media.blocks(MICROPHONE) as blocks:
            await read(frames)
            await read(blocks)
        await until(lambda: not robot.sessions)
        names = {each.name for each in threading.enumerate()}
        assert not names & {"decode video", "decode audio"}
    await until(lambda: not {each for each in asyncio.all_tasks() - tasks if _is_ours(each)})
    assert threading.active_count() <= threads + 2, "encoders of the body end on their own"


def _is_ours(task: asyncio.Task[object]) -> bool:
    """Tell whether a task belongs to an application, and not to gateway and adapter."""
    module = getattr(task.get_coro(), "cr_code", None)
    return module is not None and ("openrois_media/client" in module.co_filename or "viewing" in module.co_filename)
