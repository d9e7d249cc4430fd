"""The streams of one application from a game engine that does WebRTC itself, and their notified statuses. Pure."""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import Final

from openrois_signaling.messages import MediaKind
from openrois_streaming.errors import UnknownStream

from openrois.types.codes import StreamStatus
from openrois_avatar.facades.player import Carried

__all__ = ["Change", "FacadeStream", "SessionStreams"]

_NOT_CONNECTED: Final = StreamStatus.STREAMING_NOT_CONNECTED
_RUNNING: Final = StreamStatus.STREAMING_RUNNING
_SUSPENDED: Final = StreamStatus.STREAMING_SUSPENDED


@dataclass(frozen=True, slots=True)
class Change:
    """A change of a stream's status, or an event of that name."""

    stream_id: str
    component_ref: str
    status: StreamStatus


@dataclass(slots=True, eq=False)
class FacadeStream:
    """A stream of the application, its status, and the last notified status."""

    what: Carried
    suspended: bool = False
    status: StreamStatus = _NOT_CONNECTED
    notified: StreamStatus = _NOT_CONNECTED


class SessionStreams:
    """All streams of an application. `notify_changes` reports every change of a status once.

    Args:
        changed: called with each change.
    """

    def __init__(self, changed: Callable[[Change], None]) -> None:
        self._changed = changed
        self._streams: dict[str, FacadeStream] = {}
        self._ended: list[FacadeStream] = []
        """Streams whose end was not notified yet."""

    def __iter__(self) -> Iterator[FacadeStream]:
        return iter(tuple(self._streams.values()))

    def __len__(self) -> int:
        """Return the number of streams that have not ended."""
        return len(self._streams)

    @property
    def is_over(self) -> bool:
        """Whether there are no streams, and every end was notified."""
        return not (self._streams or self._ended)

    def __getitem__(self, stream_id: str) -> FacadeStream:
        """Return the stream of that id. Raises UnknownStream."""
        try:
            return self._streams[stream_id]
        except KeyError:
            raise UnknownStream("the stream does not exist, or has ended") from None

    def has(self, kind: MediaKind) -> bool:
        """Return whether there is a stream of this kind."""
        return any(stream.what.kind == kind for stream in self)

    def add(self, what: Carried) -> None:
        """Add a stream that is not carried yet."""
        self._streams[what.stream_id] = FacadeStream(what)

    def suspend(self, stream_id: str) -> None:
        """Suspend a stream. Raises UnknownStream."""
        stream = self[stream_id]
        stream.suspended, stream.status = True, _SUSPENDED

    def resume(self, stream_id: str) -> None:
        """Resume a stream; its status is suspended until it is carried. Raises UnknownStream."""
        self[stream_id].suspended = False

    def end_stream(self, stream: FacadeStream) -> None:
        """End a stream; its id is unknown from now on."""
        del self._streams[stream.what.stream_id]
        stream.status = _NOT_CONNECTED
        self._ended.append(stream)

    def end_all(self, *, but: Collection[Carried] = ()) -> None:
        """End all streams but these."""
        for stream in self:
            if stream.what not in but:
                self.end_stream(stream)

    def wanted(self) -> tuple[Carried, ...]:
        """Return the streams that have to be carried."""
        return tuple(stream.what for stream in self if not stream.suspended)

    def suspended(self) -> frozenset[Carried]:
        """Return the suspended streams."""
        return frozenset(stream.what for stream in self if stream.suspended)

    def run(self, carried: Collection[Carried]) -> None:
        """Set the status of carried streams to running."""
        for stream in self:
            if not stream.suspended and stream.what in carried:
                stream.status = _RUNNING

    def notify_changes(self) -> None:
        """Report every changed status, and every end."""
        ended, self._ended = self._ended, []
        for stream in (*ended, *self):
            if stream.status is not stream.notified or stream in ended:
                if stream.notified is _SUSPENDED and stream.status is _RUNNING:
                    self._notify_status(stream, StreamStatus.STREAMING_RESUMED)
                stream.notified = stream.status
                self._notify_status(stream, stream.status)

    def _notify_status(self, stream: FacadeStream, status: StreamStatus) -> None:
        self._changed(Change(stream.what.stream_id, stream.what.component_ref, status))
