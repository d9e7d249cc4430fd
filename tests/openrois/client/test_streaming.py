"""Streams: the verbs over the extension and in strict RoIS, and the notifications that negotiate media."""

import asyncio

import pytest

from openrois.client import Client, streaming
from openrois.client.components import AudioStreaming, VideoStreaming
from openrois.engine.registry import LocalRegistry
from openrois.errors import ComponentFailed, Unsupported
from openrois.types.codes import StreamStatus
from openrois.types.streams import StreamStatusNotification
from tests.support.grounds import Ground, Line, eventually, serve_plain
from tests.support.streams import Camera, FakeStreams

pytestmark = pytest.mark.extra(name="base")


@pytest.fixture
async def streams(line: Line) -> FakeStreams:
    """An engine `cameras` whose streams belong to the application that connected them."""
    streams = FakeStreams("cameras")
    await line.host.engine.attach(LocalRegistry("cameras", (Camera(),), extension=streams))
    return streams


async def test_a_stream_of_an_engine_that_has_strict_rois_alone(ground: Ground, client: Client) -> None:
    camera = client.component(VideoStreaming, "robot/video_streaming")
    async with camera.notify_stream_status() as statuses:
        stream_id = await camera.connect_stream()
        assert stream_id == "video_streaming-1"
        assert await camera.get_stream_status(stream_id) is StreamStatus.STREAMING_RUNNING
        await camera.suspend_stream(stream_id)
        assert await camera.get_stream_status(stream_id) is StreamStatus.STREAMING_SUSPENDED
        await camera.resume_stream(stream_id)
        await camera.disconnect_stream(stream_id)
        told = [await anext(statuses) for _ in range(5)]
    assert {each.stream_id for each in told} == {stream_id}
    assert [each.status for each in told] == [
        "STREAMING_RUNNING",
        "STREAMING_SUSPENDED",
        "STREAMING_RESUMED",
        "STREAMING_RUNNING",
        "STREAMING_NOT_CONNECTED",
    ]
    with pytest.raises(Unsupported if ground.extended else ComponentFailed):
        await camera.disconnect_stream(stream_id)


async def test_in_strict_rois_parameters_are_the_components(ground: Ground, client: Client) -> None:
    microphone = client.component(AudioStreaming, "robot/audio_streaming")
    if ground.extended:
        # The gateway has the extension and the engine behind it has not: what to do about that is the application's.
        with pytest.raises(Unsupported, match="has no stream with these parameters"):
            await microphone.connect_stream(encoding={"codecs": ["audio/opus"]})
    else:
        await microphone.connect_stream(encoding={"codecs": ["audio/opus"]})
        assert (await microphone.parameters()).encoding_parameters == '{"codecs": ["audio/opus"]}'


async def test_a_stream_over_the_extension(line: Line, streams: FakeStreams) -> None:
    async with Client(dial=line.dial) as client:
        offers = client.notifications("signaling.offer")
        statuses = client.notifications(StreamStatusNotification.method)
        camera = await client.find(VideoStreaming, "component_ref LIKE 'cameras/%'")
        async with camera.notify_stream_status() as events:
            stream_id = await camera.connect_stream(
                encoding={"codecs": ["video/VP8"]}, transport={"direction": "recvonly"}
            )
            method, params, _ = streams.calls[-1]
            assert method == "rois.stream.connect_stream"
            assert [(each["name"], each["value"]) for each in params["parameters"]] == [
                ("encoding_parameters", '{"codecs": ["video/VP8"]}'),
                ("transport_parameters", '{"direction": "recvonly"}'),
            ]
            offer = await anext(offers)
            assert offer.method == "signaling.offer"
            assert offer.params["streams"][0]["stream_id"] == stream_id
            assert (await anext(statuses)).params["stream_id"] == stream_id
            assert (await anext(events)).stream_id == stream_id
            await camera.suspend_stream(stream_id)
            await camera.resume_stream(stream_id)
            assert await camera.get_stream_status(stream_id) is StreamStatus.STREAMING_RUNNING
            await camera.report_playout(stream_id, 0.1504)
            await camera.report_playout(stream_id, 1e6)
            told = [params["milliseconds"] for _, params, _ in streams.calls[-2:]]
            assert told == [150, 60_000]
            await camera.disconnect_stream(stream_id)
        assert [name.rpartition(".")[2] for name, _, _ in streams.calls] == [
            "connect_stream",
            "suspend_stream",
            "resume_stream",
            "query_stream_status",
            "report_playout",
            "report_playout",
            "disconnect_stream",
        ]


async def test_a_plain_gateway_turns_strict_rois_into_the_extension_of_its_engine(
    line: Line, streams: FakeStreams
) -> None:
    line.speaks = serve_plain
    async with Client(dial=line.dial) as client:
        camera = client.component(VideoStreaming, "cameras/camera")
        stream_id = await camera.connect_stream()
        assert await camera.get_stream_status(stream_id) is StreamStatus.STREAMING_NOT_RUNNING
        with pytest.raises(Unsupported, match="takes no playout reports"):
            await camera.report_playout(stream_id, 0.1)
        await camera.disconnect_stream(stream_id)
        assert not streams.streams


async def test_a_stream_whose_caller_is_gone_is_disconnected(line: Line, streams: FakeStreams) -> None:
    line.speaks = serve_plain
    async with Client(dial=line.dial) as client:
        camera = client.component(VideoStreaming, "cameras/camera")
        for refusal in (None, Unsupported("there is no more")):
            streams.may_answer.clear()
            streams.called.clear()
            streams.refusal = refusal
            connecting = asyncio.ensure_future(camera.connect_stream())
            await streams.called.wait()
            connecting.cancel()
            with pytest.raises(asyncio.CancelledError):
                await connecting
            streams.may_answer.set()
            await eventually(client, lambda: not streaming._kept)
        assert [method for method, _, _ in streams.calls].count("rois.stream.disconnect_stream") == 1
        assert not streams.streams


async def test_a_stream_of_an_engine_that_was_lost_meanwhile_is_none(line: Line) -> None:
    """What came in its place under the same name knows nothing of the stream, and would never offer it."""
    engine = line.host.engine
    former, later = FakeStreams("cameras"), FakeStreams("cameras")
    registries = [LocalRegistry("cameras", (Camera(),), extension=streams) for streams in (former, later)]
    await engine.attach(registries[0])
    former.may_answer.clear()
    async with Client(dial=line.dial) as client:
        connecting = asyncio.ensure_future(client.connect_stream("cameras/camera"))
        await former.called.wait()
        engine.detach(registries[0])
        await engine.attach(registries[1])
        former.may_answer.set()
        with pytest.raises(ComponentFailed, match="the connection to the engine ended while the stream was made"):
            await connecting
        assert await client.connect_stream("cameras/camera") in later.streams


async def test_a_stream_of_another_application_is_none(line: Line, streams: FakeStreams) -> None:
    async with Client(dial=line.dial) as one, Client(dial=line.dial) as other:
        stream_id = await one.component(VideoStreaming, "cameras/camera").connect_stream()
        camera = other.component(VideoStreaming, "cameras/camera")
        for refused in (camera.get_stream_status(stream_id), camera.disconnect_stream(stream_id)):
            with pytest.raises(Unsupported, match=f"cameras/camera has no stream {stream_id}"):
                await refused
        assert stream_id in streams.streams


async def test_the_streams_of_an_application_end_with_it(line: Line, streams: FakeStreams) -> None:
    async with Client(dial=line.dial) as client:
        await client.component(VideoStreaming, "cameras/camera").connect_stream()
        assert not streams.forgotten
    async with asyncio.timeout(60):
        await streams.gone.wait()


async def test_a_reader_of_notifications_gets_the_named_ones(line: Line) -> None:
    async with Client(dial=line.dial) as client:
        named, everything = client.notifications("rois.event.notify_event"), client.notifications()
        async with client.subscribe("rang"):
            line.host.engine.detach(line.robot.registry)
            line.bell.ring("a scale")
            await client.search()
        assert (await anext(named)).params["results"][0]["value"] == "a scale"
        assert (await anext(everything)).method == "openrois.directory.changed"
        assert (await anext(everything)).method == "rois.event.notify_event"
        named.end_feed()
        assert [each async for each in named] == []


async def test_a_plain_gateway_knows_no_extension(line: Line) -> None:
    line.speaks = serve_plain
    async with Client(dial=line.dial) as client:
        assert client.extensions == frozenset()
        assert await client.component(VideoStreaming, "robot/video_streaming").connect_stream()
