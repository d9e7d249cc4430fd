"""aiortc as it is used by most: pictures go in, and every viewer has an encoder."""

import asyncio
from contextlib import AsyncExitStack
from fractions import Fraction
from typing import Any

import av
from aiortc import RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCSessionDescription, VideoStreamTrack
from aiortc.codecs import h264
from aiortc.rtcconfiguration import RTCBundlePolicy
from openrois_streaming.clock import SystemClock
from openrois_streaming.source.fanout import Fanout, Subscription
from openrois_streaming.source.source import RawVideo
from openrois_streaming.synthetic import TalkingHead

from openrois_bench.streams.fanout.encoded import BITRATE, Answering

_WIDTH, _HEIGHT = 1280, 720


class _Pictures(VideoStreamTrack):
    def __init__(self, pictures: Subscription[RawVideo]) -> None:
        super().__init__()
        self._pictures = pictures
        self.sent = 0

    async def recv(self) -> Any:
        picture = await self._pictures.get()
        frame = av.VideoFrame.from_numpy_buffer(picture.data, format="yuv420p")
        frame.pts, frame.time_base = picture.sequence * 3000, Fraction(1, 90_000)
        self.sent += 1
        return frame


def pictures() -> Fanout[RawVideo]:
    """Return the source of pictures; each viewer's encoder keeps to the bit rate."""
    for name in ("DEFAULT_BITRATE", "MIN_BITRATE", "MAX_BITRATE"):
        getattr(h264, name)
        setattr(h264, name, BITRATE)
    return Fanout(TalkingHead(_WIDTH, _HEIGHT, clock=SystemClock()), name="head")


async def send_with_plain(stack: AsyncExitStack, number: int, source: Fanout[RawVideo], ask: Answering) -> None:
    """Connect one viewer, and wait until it plays."""
    track = _Pictures(await stack.enter_async_context(source.subscribe(1)))
    connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
    stack.push_async_callback(connection.close)
    transceiver = connection.addTransceiver(track, direction="sendonly")
    known = RTCRtpSender.getCapabilities("video").codecs
    transceiver.setCodecPreferences([each for each in known if each.mimeType in ("video/H264", "video/rtx")])
    await connection.setLocalDescription(await connection.createOffer())
    answer = await ask(number, connection.localDescription.sdp)
    await connection.setRemoteDescription(RTCSessionDescription(answer, "answer"))
    while track.sent == 0:  # noqa: ASYNC110 - aiortc does not notify
        await asyncio.sleep(0.05)
