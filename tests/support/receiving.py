"""An application that sends pictures and sound to a receiver of ours, both in this process."""

from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import av
from aiortc import MediaStreamTrack, RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCSessionDescription
from aiortc.mediastreams import MediaStreamError
from aiortc.rtcconfiguration import RTCBundlePolicy
from openrois_streaming.clock import SystemClock
from openrois_streaming.peer.receiver import RtpReceiver
from openrois_streaming.receive.remote_time import RemoteClock
from openrois_streaming.source.source import MediaSource, RawAudio, RawVideo
from openrois_streaming.synthetic import ColourBars, Tone
from openrois_streaming.testing.path import ImpairedPath

from tests.support.loopback import some_address


class SourceTrack(MediaStreamTrack):
    """A source as aiortc's senders read it."""

    def __init__(self, kind: str, source: MediaSource[Any]) -> None:
        super().__init__()
        self.kind = kind
        self._source = source
        self._stack = AsyncExitStack()
        self._items: AsyncIterator[Any] | None = None

    async def recv(self) -> av.VideoFrame | av.AudioFrame:
        if self.readyState != "live":
            raise MediaStreamError
        if self._items is None:
            self._items = await self._stack.enter_async_context(self._source.open())
        raw: RawVideo | RawAudio = await anext(self._items)
        frame: av.VideoFrame | av.AudioFrame
        if isinstance(raw, RawVideo):
            frame, rate = av.VideoFrame.from_ndarray(raw.data, format="yuv420p"), 90_000
        else:
            frame, rate = av.AudioFrame.from_ndarray(raw.samples.reshape(1, -1), format="s16", layout="mono"), 48_000
            frame.sample_rate = rate
        frame.pts, frame.time_base = round(raw.captured_at * rate), Fraction(1, rate)
        return frame

    async def aclose(self) -> None:
        self.stop()
        await self._stack.aclose()


@dataclass
class Uplink:
    """A connection over which an application sends."""

    engine: RTCPeerConnection
    application: RTCPeerConnection
    path: ImpairedPath
    video: RtpReceiver
    audio: RtpReceiver


@asynccontextmanager
async def uplink(codec: str) -> AsyncIterator[Uplink]:
    """The engine offers to receive, an application on aiortc sends bars encoded with `codec` and a tone."""
    clock, remote = SystemClock(), RemoteClock()
    tracks = [SourceTrack("video", ColourBars(320, 180, clock=clock)), SourceTrack("audio", Tone(clock=clock))]
    configuration = RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE)
    with some_address():
        path = ImpairedPath()
        engine, application = RTCPeerConnection(configuration), RTCPeerConnection(configuration)
        video = engine.addTransceiver("video", direction="recvonly")
        known = RTCRtpSender.getCapabilities("video").codecs
        video.setCodecPreferences([each for each in known if each.mimeType in (codec, "video/rtx")])
        audio = engine.addTransceiver("audio", direction="recvonly")
        receivers = [RtpReceiver(each, clock, remote) for each in (video, audio)]
        await path.__aenter__()
        try:
            await engine.setLocalDescription(await engine.createOffer())
            await application.setRemoteDescription(bent(engine.localDescription, path.to_viewer))
            for transceiver, track in zip(application.getTransceivers(), tracks, strict=True):
                transceiver.sender.replaceTrack(track)
                transceiver.direction = "sendonly"
            await application.setLocalDescription(await application.createAnswer())
            await engine.setRemoteDescription(bent(application.localDescription, path.to_engine))
            yield Uplink(engine, application, path, *receivers)
        finally:
            await application.close()
            await engine.close()
            await path.__aexit__()
            for track in tracks:
                await track.aclose()


def bent(description: RTCSessionDescription, way: Callable[[str], str]) -> RTCSessionDescription:
    return RTCSessionDescription(way(description.sdp), description.type)
