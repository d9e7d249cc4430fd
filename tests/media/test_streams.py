"""Streams of an adapter: components, publishers, health and limits made of its sources."""

import asyncio
import json
import sys
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
import pytest
from openrois_media.components import AudioStreaming, VideoStreaming
from openrois_media.running import run, serve
from openrois_media.streams import AdapterStreams, Source, Stream
from openrois_media.uplinks import AudioUplink, VideoUplink
from openrois_media.visitors.registry import VisitorRegistry
from openrois_streaming.capture.audio import AudioSource
from openrois_streaming.capture.video import EncodedSource, Picture, VideoSource
from openrois_streaming.publish.encoder_limit import EncoderLimit
from openrois_streaming.publish.publisher import VideoPublisher

from openrois.errors import BadParameter
from openrois.types.codes import ComponentStatus
from tests.support.streaming import FedSource, VirtualClock, settle


@pytest.fixture(autouse=True)
def _as_before() -> Iterator[None]:
    interval, threads = sys.getswitchinterval(), cv2.getNumThreads()
    yield
    sys.setswitchinterval(interval)
    cv2.setNumThreads(threads)


def pictures() -> Iterator[Picture]:
    while True:
        yield np.zeros((90, 160, 3), np.uint8)


def camera() -> VideoSource:
    return VideoSource(pictures, size=(160, 90))


def adapter(**streams: Source | Stream) -> AdapterStreams:
    return AdapterStreams("robot", streams, clock=VirtualClock())


def offered(component: VideoStreaming | AudioStreaming) -> tuple[Any, Any]:
    """The codecs and directions that a component offers."""
    assert component.available_encodings is not None
    assert component.available_transports is not None
    return json.loads(component.available_encodings)["codecs"], json.loads(component.available_transports)["direction"]


def test_each_source_has_a_component_of_its_name_and_kind() -> None:
    streams = adapter(
        porch=camera(),
        roof=EncodedSource(lambda: iter([]), size=(640, 360), mime_type="video/VP8"),
        mast=AudioSource(lambda: iter([])),
    )
    assert {name: type(each) for name, each in streams.components.items()} == {
        "porch": VideoStreaming,
        "roof": VideoStreaming,
        "mast": AudioStreaming,
    }
    assert [each.name for each in streams.components.values()] == ["porch", "roof", "mast"]
    assert offered(streams.components["porch"]) == (["video/H264", "video/VP8"], ["recvonly"])
    assert offered(streams.components["roof"]) == (["video/VP8"], ["recvonly"])
    assert offered(streams.components["mast"]) == (["audio/opus"], ["recvonly"])


def test_what_applications_may_send_is_offered_too() -> None:
    streams = adapter(
        eyes=Stream(camera(), VideoUplink()),
        talk=Stream(AudioSource(lambda: iter([])), AudioUplink()),
        speaker=Stream(uplink=AudioUplink()),
    )
    directions = [offered(each)[1] for each in streams.components.values()]
    assert directions == [["recvonly", "sendonly"], ["recvonly", "sendonly", "sendrecv"], ["sendonly"]]
    assert list(streams.publishers) == list(streams.supervised) == ["eyes", "talk"], "a speaker has nothing to judge"
    assert streams.components["speaker"].condition() is ComponentStatus.READY


@pytest.mark.parametrize(
    ("stream", "error", "text"),
    [
        (Stream(), ValueError, "a stream has a source, an uplink, or both of one kind of media, not neither"),
        (Stream(camera(), AudioUplink()), ValueError, "not audio and video"),
        (7, TypeError, "camera is a int and no source: use opencv_camera, v4l2_camera or ffmpeg_input"),
        (cv2.VideoCapture(), TypeError, "camera is a VideoCapture and no source: use opencv_camera"),
        (FedSource(), TypeError, "camera is a FedSource and no source: wrap it"),
    ],
)
def test_what_cannot_be_streamed_is_refused_by_name(stream: Any, error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        adapter(camera=stream)


def test_what_would_be_opened_or_counted_twice_is_refused() -> None:
    one, uplink = camera(), VideoUplink()
    with pytest.raises(ValueError, match="roof and porch have one source: a source is open once, so name it once"):
        adapter(porch=one, roof=one)
    with pytest.raises(ValueError, match="roof and porch have one uplink: make one for each"):
        adapter(porch=Stream(uplink=uplink), roof=Stream(camera(), uplink))
    with pytest.raises(ValueError, match="'front' is the label of two streams: give each its own"):
        adapter(porch=Stream(camera(), label="front"), roof=Stream(camera(), label="front"))
    with pytest.raises(ValueError, match="'porch' is the label of two streams"):
        adapter(porch=camera(), roof=Stream(camera(), label="porch"))


def test_visitors_of_several_registries_are_refused() -> None:
    one, other = VisitorRegistry("robot"), VisitorRegistry("robot")
    with pytest.raises(ValueError, match="make one VisitorRegistry for all"):
        adapter(ears=Stream(uplink=one.microphones), eyes=Stream(uplink=other.cameras))
    with pytest.raises(ValueError, match="right and left have one uplink: make one for each"):
        adapter(left=Stream(uplink=one.microphones), right=Stream(uplink=one.microphones))
    assert adapter(ears=Stream(uplink=one.microphones), eyes=Stream(uplink=one.cameras)).interface.visitors is one


def test_a_name_that_no_reference_has_is_refused() -> None:
    with pytest.raises(BadParameter, match="front/camera"):
        AdapterStreams("robot", {"front/camera": camera()})


def test_all_pictures_of_an_adapter_share_one_limit_on_encoders() -> None:
    limit = EncoderLimit(3)
    streams = AdapterStreams("robot", {"one": camera(), "two": camera()}, encoders=limit)
    one, two = streams.publishers.values()
    assert isinstance(one, VideoPublisher)
    assert isinstance(two, VideoPublisher)
    with one.renditions("video/H264")[0].wanted(), one.renditions("video/VP8")[0].wanted():
        assert two.has_room("video/H264")
        with two.renditions("video/H264")[0].wanted():
            assert not two.has_room("video/VP8"), "three encoders run"
            assert one.has_room("video/VP8"), "what runs can be watched by more"
    assert two.has_room("video/VP8")


async def test_a_source_that_fails_is_an_error_of_its_component_alone() -> None:
    def gone() -> Iterator[Picture]:
        raise OSError("the cable is out")
        yield

    clock, whole = VirtualClock(), ComponentStatus.READY
    streams = AdapterStreams(
        "robot",
        {
            "porch": Stream(VideoSource(gone, size=(160, 90), clock=clock), label="picture", status=lambda: whole),
            "mast": AudioSource(lambda: iter([])),
        },
        clock=clock,
    )
    porch, mast = streams.components.values()
    told: list[str] = []
    porch.report = lambda kind, text: told.append(text)
    picture = streams.publishers["picture"]
    async with asyncio.timeout(30), streams, picture.renditions("video/H264")[0].play("v", lambda frame: None, None):
        while not picture.failure:
            await settle()
        await clock.advance(1)
        assert (porch.condition(), mast.condition()) == (ComponentStatus.ERROR, ComponentStatus.READY)
        assert told[0] == "the source of picture has failed: the cable is out"


async def test_a_component_is_as_well_as_what_it_is_a_part_of() -> None:
    whole = ComponentStatus.WARNING
    streams = adapter(porch=Stream(camera(), status=lambda: whole))
    assert streams.components["porch"].condition() is ComponentStatus.WARNING
    whole = ComponentStatus.READY
    assert streams.components["porch"].condition() is ComponentStatus.READY


async def test_its_figures_are_by_label() -> None:
    streams = adapter(porch=Stream(camera(), label="picture"), mast=AudioSource(lambda: iter([])))
    async with streams:
        snapshot = await streams.collector().snapshot()
    assert [each.name for each in snapshot.sources] == ["picture", "mast"]


async def test_limits_are_checked_before_anything_runs() -> None:
    with pytest.raises(ValueError, match="max_encoders must be 1 or more, not 0"):
        run(engine_id="robot", streams={"camera": camera()}, max_encoders=0)
    with pytest.raises(ValueError, match="max_encoders must be 1 or more, not -1"):
        async with serve(engine_id="robot", streams={"camera": camera()}, max_encoders=-1):
            pass


async def test_threads_of_a_process_that_serves_streams_are_set_as_by_run() -> None:
    sys.setswitchinterval(0.005)
    cv2.setNumThreads(2)
    async with serve(engine_id="robot", streams={"camera": camera()}, gateway="ws://127.0.0.1:9/adapter"):
        assert sys.getswitchinterval() == pytest.approx(0.0005)
        assert cv2.getNumThreads() == 1
    assert cv2.getNumThreads() == 1, "other streams of the process may still run"
