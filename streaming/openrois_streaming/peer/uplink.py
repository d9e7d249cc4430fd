"""Uplink of an application's media into the engine, over one m-section."""

from typing import Any, Protocol

from openrois_streaming.clock import MediaClock
from openrois_streaming.liveness import Arrival, Verdict
from openrois_streaming.source.source import MediaSource
from openrois_streaming.source.uplink_sink import UplinkSelector
from openrois_streaming.stats import ReceiverFigures


class Reception(Protocol):
    """Receiver of one m-section; see `openrois_streaming.receive`."""

    @property
    def source(self) -> MediaSource[Any]:
        """Media source of the section, decoded while it is open."""
        ...

    @property
    def frames(self) -> int:
        """Number of whole frames that arrived so far, decoded or not."""
        ...

    @property
    def last_frame_at(self) -> float | None:
        """Time of the last frame, on the media clock."""
        ...

    @property
    def figures(self) -> ReceiverFigures:
        """Counts of its packets so far."""
        ...

    def pass_media(self, wanted: bool) -> None:
        """Set whether packets are read; unwanted ones are dropped."""
        ...


class Uplink:
    """Path of a stream into the engine. It is plugged in while there is a media path, suspended or not."""

    def __init__(self, reception: Reception, selector: UplinkSelector, clock: MediaClock) -> None:
        self._reception = reception
        self._selector = selector
        self._clock = clock
        self._arrival = Arrival()
        self._there = False
        self._open = False
        self._frames_before, self._before = reception.frames, reception.figures
        reception.pass_media(False)

    @property
    def frames(self) -> int:
        """Number of whole frames that arrived so far, decoded or not."""
        return self._reception.frames - self._frames_before

    @property
    def figures(self) -> ReceiverFigures:
        """Counts of its packets so far."""
        return self._reception.figures.since(self._before)

    def follow(self, *, there: bool, wanted: bool) -> None:
        """Set whether the application can send over this path (`there`) and whether it shall (`wanted`)."""
        if there is not self._there:
            self._there = there
            if there:
                self._selector.add(self._reception.source)
            else:
                self._selector.remove(self._reception.source)
        opened = there and wanted
        if opened is not self._open:
            self._open = opened
            self._reception.pass_media(opened)
            if opened:
                self._arrival.opened(self._clock.now())
            else:
                self._arrival.closed()

    def judge(self, now: float) -> Verdict:
        """Judge whether media arrives; a path by which it does is plugged in."""
        verdict = self._arrival.judge(now, self._reception.last_frame_at)
        if self._there:
            self._selector.set_playing(self._reception.source, plays=verdict is Verdict.FLOWING)
        return verdict

    def close(self) -> None:
        """Close the path."""
        self.follow(there=False, wanted=False)
