"""aiortc as it is used by most, behind as much of the wire as the viewers of `openrois bench` need.

Run by `__main__` as `python -m openrois_bench.streams.latency.plain WIDTH HEIGHT FPS bars|head`; it prints where it
listens. A suspended stream is one whose track is given no pictures.
"""

import asyncio
import json
import sys
from fractions import Fraction
from typing import Any

import av
import uvloop
from aiohttp import WSMsgType, web
from aiortc import RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCSessionDescription, VideoStreamTrack
from aiortc.rtcconfiguration import RTCBundlePolicy
from openrois_streaming.clock import SystemClock, wall_at
from openrois_streaming.codecs import H264
from openrois_streaming.source.fanout import Fanout, Subscription
from openrois_streaming.source.source import RawVideo
from openrois_streaming.source.stamp import stamped
from openrois_streaming.synthetic import ColourBars, TalkingHead

_CLOCK_RATE = 90_000
# aiortc waits for names of mDNS to be resolved, and takes the viewer's address from its first check instead.
_CANDIDATES = ("a=candidate", "a=end-of-candidates")
_ANSWERS: dict[str, dict[str, Any]] = {
    "hello": {"extensions": ["rois.stream"]},
    "connect_stream": {"stream_id": "plain/1"},
}
"""What a result has beside its code."""


class _Pictures(VideoStreamTrack):
    def __init__(self, pictures: Subscription[RawVideo], clock: SystemClock) -> None:
        super().__init__()
        self.playing = asyncio.Event()
        self.playing.set()
        self._pictures = pictures
        self._clock = clock

    async def recv(self) -> av.VideoFrame:
        while True:
            picture = await self._pictures.get()
            if self.playing.is_set():
                break
        picture = stamped(picture, wall_at(self._clock, picture.captured_at))
        frame = av.VideoFrame.from_numpy_buffer(picture.data, format="yuv420p")
        frame.pts, frame.time_base = round(picture.captured_at * _CLOCK_RATE), Fraction(1, _CLOCK_RATE)
        return frame


class _Application:
    """One viewer's WebSocket, with one stream."""

    def __init__(self, socket: web.WebSocketResponse, pictures: Subscription[RawVideo], clock: SystemClock) -> None:
        self._socket = socket
        self._track = _Pictures(pictures, clock)
        self.connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))

    async def handle_message(self, message: dict[str, Any]) -> None:
        verb = message["method"].rpartition(".")[2]
        params = message.get("params", {})
        if verb == "suspend_stream":
            self._track.playing.clear()
        elif verb == "resume_stream":
            self._track.playing.set()
        elif verb == "answer":
            lines = params["sdp"].splitlines(keepends=True)
            sdp = "".join(line for line in lines if not line.startswith(_CANDIDATES))
            await self.connection.setRemoteDescription(RTCSessionDescription(sdp, "answer"))
        await self._send(id=message["id"], result={"return_code": "OK", **_ANSWERS.get(verb, {})})
        if verb == "connect_stream":
            await self._send(method="signaling.offer", params=await self._offer())

    async def _offer(self) -> dict[str, Any]:
        transceiver = self.connection.addTransceiver(self._track, direction="sendonly")
        known = RTCRtpSender.getCapabilities("video").codecs
        transceiver.setCodecPreferences([each for each in known if each.mimeType in (H264, "video/rtx")])
        await self.connection.setLocalDescription(await self.connection.createOffer())
        return {"peer_id": "plain/p1", "generation": 1, "sdp": self.connection.localDescription.sdp}

    async def _send(self, **message: Any) -> None:
        await self._socket.send_str(json.dumps({"jsonrpc": "2.0", **message}))


async def _serve(width: int, height: int, fps: float, show: str) -> None:
    clock = SystemClock()
    pictures = TalkingHead if show == "head" else ColourBars
    source: Fanout[RawVideo] = Fanout(pictures(width, height, fps, clock=clock), name=show)

    async def application(request: web.Request) -> web.WebSocketResponse:
        socket = web.WebSocketResponse()
        await socket.prepare(request)
        async with source.subscribe(1) as pictures:
            one = _Application(socket, pictures, clock)
            try:
                async for message in socket:
                    if message.type is WSMsgType.TEXT:
                        await one.handle_message(json.loads(message.data))
            finally:
                await one.connection.close()
        return socket

    app = web.Application()
    app.router.add_get("/", application)
    runner = web.AppRunner(app, access_log=None, shutdown_timeout=0.5)
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", 0).start()
    print(f"listening ws://127.0.0.1:{runner.addresses[0][1]}/", flush=True)
    await asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)
    await runner.cleanup()


if __name__ == "__main__":
    uvloop.run(_serve(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]), sys.argv[4]))
