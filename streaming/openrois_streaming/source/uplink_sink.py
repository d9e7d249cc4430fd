"""Where an application's media arrives in the engine, whatever peer connection brings it."""

from typing import Any, Protocol

from openrois_streaming.source.source import MediaSource


class UplinkSink(Protocol):
    """What takes the media of applications in. All calls are made in the event loop and must not block."""

    def plug(self, stream_id: str, source: MediaSource[Any]) -> None:
        """`source` brings the media of a stream from now on, in place of the one that did before.

        Nothing is decoded while nobody has it open.
        """
        ...

    def unplug(self, stream_id: str) -> None:
        """Nothing brings the media of the stream any more; its source ends."""
        ...


class UplinkSelector:
    """Which of its media paths brings a stream to its inlet: of those that play, the one that was added last."""

    def __init__(self, stream_id: str, inlet: UplinkSink) -> None:
        self._stream_id = stream_id
        self._inlet = inlet
        self._sources: list[MediaSource[Any]] = []
        self._playing: list[MediaSource[Any]] = []
        self._plugged: MediaSource[Any] | None = None

    def add(self, source: MediaSource[Any]) -> None:
        """`source` can bring the stream, too; it does so at once if no other can."""
        self._sources.append(source)
        self._plug(self._plugged or source)

    def heard(self, source: MediaSource[Any], *, plays: bool) -> None:
        """Whether media comes by `source`, which was added; who moves may send by both ways for a while."""
        if plays is not (source in self._playing):
            self._playing = (
                [*self._playing, source] if plays else [each for each in self._playing if each is not source]
            )
            self._choose()

    def remove(self, source: MediaSource[Any]) -> None:
        """`source` brings nothing more; another one takes its place. Unknown ones are fine."""
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
