"""A streaming component and an engine's streams without media, for tests of the control plane."""

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from openrois.adapter.components import VideoStreaming
from openrois.contract import Client
from openrois.errors import Unsupported
from openrois.types.codes import StreamStatus
from openrois.types.references import new_id
from openrois.types.streams import HolderNotification, StreamStatusNotification


class Camera(VideoStreaming):
    """A streaming component whose verbs are its engine's extension."""

    def __init__(self, name: str = "camera") -> None:
        super().__init__(name)

    async def connect_stream(self) -> str:
        raise Unsupported("only for an application")

    async def disconnect_stream(self, stream_id: str) -> None:
        raise Unsupported("only for an application")

    async def suspend_stream(self, stream_id: str) -> None:
        raise Unsupported("only for an application")

    async def resume_stream(self, stream_id: str) -> None:
        raise Unsupported("only for an application")

    async def get_stream_status(self) -> StreamStatus:
        raise Unsupported("only for an application")


class SharedCamera(Camera):
    """The same in strict RoIS alone: one stream shared by all applications."""

    def __init__(self, name: str = "camera") -> None:
        super().__init__(name)
        self.asked: list[str] = []

    async def connect_stream(self) -> str:
        self.asked.append("connect_stream")
        self.tell(StreamStatus.STREAMING_NOT_RUNNING)
        return "the stream"

    async def disconnect_stream(self, stream_id: str) -> None:
        self.asked.append(stream_id)

    async def suspend_stream(self, stream_id: str) -> None:
        self.asked.append(stream_id)

    async def resume_stream(self, stream_id: str) -> None:
        self.asked.append(stream_id)

    async def get_stream_status(self) -> StreamStatus:
        return StreamStatus.STREAMING_RUNNING

    def tell(self, status: StreamStatus) -> None:
        self.notify_stream_status(status)


@dataclass
class Stream:
    """A stream of one application."""

    client: Client
    component_ref: str
    status: StreamStatus


class FakeStreams:
    """The streams of one engine; an `Extension`. Notifications of a call come before its response.

    Attributes:
        calls: every call: its method, its params, the client_id.
        forgotten: the clients that are gone.
        may_answer: calls wait until it is set.
        refusal: what a call raises, if set.
    """

    def __init__(self, engine_id: str = "robot") -> None:
        self.engine_id = engine_id
        self.streams: dict[str, Stream] = {}
        self.calls: list[tuple[str, dict[str, Any], str]] = []
        self.called = asyncio.Event()
        self.forgotten: list[str] = []
        self.gone = asyncio.Event()
        self.refusal: Exception | None = None
        self.may_answer = asyncio.Event()
        self.may_answer.set()

    takes_role = True

    def engines(self) -> frozenset[str]:
        return frozenset({self.engine_id})

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        self.calls.append((method, dict(params), client.client_id))
        self.called.set()
        await self.may_answer.wait()
        if self.refusal is not None:
            raise self.refusal
        match method:
            case "rois.stream.connect_stream":
                return self._connect(params["component_ref"], client)
            case "rois.stream.query_stream_status":
                return {"return_code": "OK", "status": self._own(params, client).status.value}
            case "rois.stream.suspend_stream":
                self._own(params, client)
                self.announce(params["stream_id"], StreamStatus.STREAMING_SUSPENDED)
            case "rois.stream.resume_stream":
                self._own(params, client)
                self.announce(params["stream_id"], StreamStatus.STREAMING_RESUMED, StreamStatus.STREAMING_RUNNING)
            case "rois.stream.disconnect_stream":
                self._own(params, client)
                self.end(params["stream_id"])
        return {"return_code": "OK"}

    def _connect(self, component_ref: str, client: Client) -> dict[str, Any]:
        stream_id = new_id(self.engine_id)
        self.streams[stream_id] = Stream(client, component_ref, StreamStatus.STREAMING_NOT_RUNNING)
        self.announce(stream_id, StreamStatus.STREAMING_NOT_RUNNING)
        section = {"mid": "0", "stream_id": stream_id, "component_ref": component_ref}
        self.offer(client, new_id(self.engine_id), streams=[{**section, "kind": "video", "direction": "recvonly"}])
        return {"return_code": "OK", "stream_id": stream_id}

    def _own(self, params: Mapping[str, Any], client: Client) -> Stream:
        stream = self.streams.get(params["stream_id"])
        if stream is None or stream.client is not client:
            raise Unsupported("there is no such stream")
        return stream

    def offer(self, client: Client, peer_id: str, streams: list[dict[str, Any]]) -> None:
        """Send an offer to `client`."""
        offer = {"peer_id": peer_id, "generation": 1, "sdp": "v=0", "streams": streams}
        client.notify("signaling.offer", offer)

    def announce(self, stream_id: str, *statuses: StreamStatus) -> None:
        """Notify the owner of a stream's status."""
        stream = self.streams[stream_id]
        for status in statuses:
            if status is not StreamStatus.STREAMING_RESUMED:
                stream.status = status
            notice = StreamStatusNotification(
                stream_id=stream_id,
                component_ref=stream.component_ref,
                status=status,
                timestamp="2026-06-01T12:00:00+00:00",
            )
            stream.client.notify(notice.method, notice.model_dump(mode="json"))

    def end(self, stream_id: str) -> None:
        """End a stream."""
        self.announce(stream_id, StreamStatus.STREAMING_NOT_CONNECTED)
        del self.streams[stream_id]

    async def set_holder(self, notification: HolderNotification, client: Client) -> None:
        self.calls.append((notification.method, notification.model_dump(), client.client_id))
        self.called.set()
        await self.may_answer.wait()

    async def forget_client(self, client: Client) -> None:
        self.forgotten.append(client.client_id)
        for stream_id in [key for key, stream in self.streams.items() if stream.client is client]:
            del self.streams[stream_id]
        self.gone.set()
