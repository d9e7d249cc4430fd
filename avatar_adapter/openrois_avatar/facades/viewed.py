"""The streams of one application of a game engine that does WebRTC itself, and what was told about each. Pure."""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import Final

from openrois_signaling.messages import MediaKind
from openrois_streaming.errors import UnknownStream

from openrois.types.codes import StreamStatus
from openrois_avatar.facades.player import Carried

__all__ = ["Change", "Viewed", "ViewedStreams"]

_NOT_CONNECTED: Final = StreamStatus.STREAMING_NOT_CONNECTED
_RUNNING: Final = StreamStatus.STREAMING_RUNNING
_SUSPENDED: Final = StreamStatus.STREAMING_SUSPENDED


@dataclass(frozen=True, slots=True)
class Change:
    """A stream has another status, or an event of that name has happened to it."""

    stream_id: str
    component_ref: str
    status: StreamStatus


@dataclass(slots=True, eq=False)
class Viewed:
    """A stream of the application, what it does, and what of that was told last."""

    what: Carried
    suspended: bool = False
    status: StreamStatus = _NOT_CONNECTED
    told: StreamStatus = _NOT_CONNECTED


class ViewedStreams:
    """All streams of an application. Every change of a status is told once, by `tell`.

    Args:
        changed: is told it.
    """

    def __init__(self, changed: Callable[[Change], None]) -> None:
        self._changed = changed
        self._streams: dict[str, Viewed] = {}
        self._ended: list[Viewed] = []
        """Of whose end nothing was told yet."""

    def __iter__(self) -> Iterator[Viewed]:
        return iter(tuple(self._streams.values()))

    def __len__(self) -> int:
        """How many have not ended."""
        return len(self._streams)

    @property
    def is_over(self) -> bool:
        """Whether there are none, and every end was told."""
        return not (self._streams or self._ended)

    def __getitem__(self, stream_id: str) -> Viewed:
        """The stream of that id. Raises UnknownStream."""
        try:
            return self._streams[stream_id]
        except KeyError:
            raise UnknownStream("there is no such stream") from None

    def has(self, kind: MediaKind) -> bool:
        """Whether there is one of this kind."""
        return any(stream.what.kind == kind for stream in self)

    def add(self, what: Carried) -> None:
        """There is a new one, of which nothing is carried yet."""
        self._streams[what.stream_id] = Viewed(what)

    def suspend(self, stream_id: str) -> None:
        """Nothing of it is to be carried. Raises UnknownStream."""
        stream = self[stream_id]
        stream.suspended, stream.status = True, _SUSPENDED

    def resume(self, stream_id: str) -> None:
        """It is to be carried again; it counts as suspended until it is. Raises UnknownStream."""
        self[stream_id].suspended = False

    def end(self, stream: Viewed) -> None:
        """It is over, and unknown from now on."""
        del self._streams[stream.what.stream_id]
        stream.status = _NOT_CONNECTED
        self._ended.append(stream)

    def end_all(self, *, but: Collection[Carried] = ()) -> None:
        """All are over, but these."""
        for stream in self:
            if stream.what not in but:
                self.end(stream)

    def wanted(self) -> tuple[Carried, ...]:
        """What is to be carried."""
        return tuple(stream.what for stream in self if not stream.suspended)

    def suspended(self) -> frozenset[Carried]:
        """What is not to be carried."""
        return frozenset(stream.what for stream in self if stream.suspended)

    def run(self, carried: Collection[Carried]) -> None:
        """These are carried now."""
        for stream in self:
            if not stream.suspended and stream.what in carried:
                stream.status = _RUNNING

    def tell(self) -> None:
        """Tell every status that is not the one that was told last, and every end."""
        ended, self._ended = self._ended, []
        for stream in (*ended, *self):
            if stream.status is not stream.told or stream in ended:
                if stream.told is _SUSPENDED and stream.status is _RUNNING:
                    self._tell(stream, StreamStatus.STREAMING_RESUMED)
                stream.told = stream.status
                self._tell(stream, stream.status)

    def _tell(self, stream: Viewed, status: StreamStatus) -> None:
        self._changed(Change(stream.what.stream_id, stream.what.component_ref, status))
