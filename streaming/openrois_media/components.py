"""VideoStreaming and AudioStreaming (components 16 and 17): available encodings and transports, and status.

The streaming verbs need the calling application, so they arrive as extension calls (`streaming_interface`); the
application's engine turns `execute`, `query` and `subscribe` with these verbs into the same calls.
"""

import json
from collections.abc import Callable, Iterable
from typing import NoReturn

from openrois.adapter import ComponentStatus, StreamStatus, Unsupported, components

__all__ = ["AudioStreaming", "VideoStreaming"]


class _Streaming:
    """Common part of both components."""

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
        """Set the media types that are available from now on, best first."""
        self.available_encodings = json.dumps({"codecs": list(codecs)})

    def condition(self) -> ComponentStatus:
        """Return the status of the source."""
        return self._source_status()

    async def connect_stream(self) -> str:
        """Refuse, as the other verbs: without its application a stream has no owner."""
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
    raise Unsupported("a stream needs its application: use the methods rois.stream.*")


class VideoStreaming(_Streaming, components.VideoStreaming):
    """Pictures of a body, and the sink of its operator's camera.

    Args:
        codecs: available media types, best first.
        directions: available directions of an application (W3C's terms).
        source_status: returns the status of the source.
        name: of the component; the type's unless given.
    """

    def __init__(
        self,
        codecs: Iterable[str],
        directions: Iterable[str],
        source_status: Callable[[], ComponentStatus],
        name: str | None = None,
    ) -> None:
        super().__init__(name)
        self._offer(codecs, directions, source_status)


class AudioStreaming(_Streaming, components.AudioStreaming):
    """Sound of a body, and the sink of its operator's microphone; as `VideoStreaming`."""

    def __init__(
        self,
        codecs: Iterable[str],
        directions: Iterable[str],
        source_status: Callable[[], ComponentStatus],
        name: str | None = None,
    ) -> None:
        super().__init__(name)
        self._offer(codecs, directions, source_status)
