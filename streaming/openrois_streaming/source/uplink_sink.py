"""Sinks of the media that applications send, over any of their peer connections."""

from typing import Any, Protocol

from openrois_streaming.source.source import MediaSource


class UplinkSink(Protocol):
    """Sink of the media that applications send. All calls are made in the event loop and must not block."""

    def plug(self, stream_id: str, source: MediaSource[Any]) -> None:
        """Take the media of a stream from `source` from now on, in place of any earlier one.

        It is decoded only while it is open.
        """
        ...

    def unplug(self, stream_id: str) -> None:
        """Take no more media of the stream; its source ends."""
        ...


class UplinkSelector:
    """Selection among the media paths of a stream into its sink: of those that play, the one added last."""

    def __init__(self, stream_id: str, inlet: UplinkSink) -> None:
        self._stream_id = stream_id
        self._inlet = inlet
        self._sources: list[MediaSource[Any]] = []
        self._playing: list[MediaSource[Any]] = []
        self._plugged: MediaSource[Any] | None = None

    def add(self, source: MediaSource[Any]) -> None:
        """Add `source` as a path of the stream; it is used at once if it is the only one."""
        self._sources.append(source)
        self._plug(self._plugged or source)

    def set_playing(self, source: MediaSource[Any], *, plays: bool) -> None:
        """Set whether media arrives by `source`; an application that changes paths may send by both for a while."""
        if plays is not (source in self._playing):
            self._playing = (
                [*self._playing, source] if plays else [each for each in self._playing if each is not source]
            )
            self._choose()

    def remove(self, source: MediaSource[Any]) -> None:
        """Remove `source`, which another one replaces; an unknown source is ignored."""
        if source in self._sources:
            self._sources.remove(source)
            self._playing = [each for each in self._playing if each is not source]
            self._choose()

    def _choose(self) -> None:
        playing = [each for each in self._sources if each in self._playing]
        if playing:
            self._plug(playing[-1])
        elif self._plugged not in self._sources:
            self._plug(self._sources[-1] if self._sources else None)

    def _plug(self, source: MediaSource[Any] | None) -> None:
        if source is self._plugged:
            return
        self._plugged = source
        if source is None:
            self._inlet.unplug(self._stream_id)
        else:
            self._inlet.plug(self._stream_id, source)
