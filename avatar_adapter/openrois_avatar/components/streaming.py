"""VideoStreaming and AudioStreaming (components 16 and 17): what can be streamed, and how the streams fare.

The streaming verbs need to know which application asks, so they arrive as extension calls (`openrois_avatar.streams`);
the engine that the application speaks to turns `execute`, `query` and `subscribe` with these verbs into the same calls.
"""

import json
from collections.abc import Callable, Iterable
from typing import NoReturn

from openrois.adapter import ComponentStatus, StreamStatus, Unsupported, components

__all__ = ["AudioStreaming", "VideoStreaming"]


class _Streaming:
    """What both have in common."""

    available_encodings: str | None
    available_transports: str | None
    _source_status: Callable[[], ComponentStatus]

    def _offer(
        self, codecs: Iterable[str], directions: Iterable[str], source_status: Callable[[], ComponentStatus]
    ) -> None:
        self._source_status = source_status
        self.offer_codecs(codecs)
        self.available_transports = json.dumps({"direction": list(directions)})

    def offer_codecs(self, codecs: Iterable[str]) -> None:
        """It can be streamed in these media types from now on, best first."""
        self.available_encodings = json.dumps({"codecs": list(codecs)})

    def condition(self) -> ComponentStatus:
        """Follow the source."""
        return self._source_status()

    async def connect_stream(self) -> str:
        """Refuse, as all the others do: without the application a stream would belong to nobody."""
        _refuse()

    async def disconnect_stream(self, stream_id: str) -> None:
        """Refuse."""
        _refuse()

    async def suspend_stream(self, stream_id: str) -> None:
        """Refuse."""
        _refuse()

    async def resume_stream(self, stream_id: str) -> None:
        """Refuse."""
        _refuse()

    async def get_stream_status(self) -> StreamStatus:
        """Refuse."""
        _refuse()


def _refuse() -> NoReturn:
    raise Unsupported("streams belong to an application: they are there through the streaming methods")


class VideoStreaming(_Streaming, components.VideoStreaming):
    """What the avatar looks like, and where its operator's camera is sent to.

    Args:
        codecs: the media types it can be streamed in, best first.
        directions: what an application can do, as W3C says it.
        source_status: tells whether there is something to stream now.
    """

    def __init__(
        self, codecs: Iterable[str], directions: Iterable[str], source_status: Callable[[], ComponentStatus]
    ) -> None:
        super().__init__()
        self._offer(codecs, directions, source_status)


class AudioStreaming(_Streaming, components.AudioStreaming):
    """What the avatar sounds like, and where its operator's microphone is sent to; as `VideoStreaming`."""

    def __init__(
        self, codecs: Iterable[str], directions: Iterable[str], source_status: Callable[[], ComponentStatus]
    ) -> None:
        super().__init__()
        self._offer(codecs, directions, source_status)
