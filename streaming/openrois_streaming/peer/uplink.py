"""The media of an application on its way into the engine, over one m-section."""

from typing import Any, Protocol

from openrois_streaming.clock import MediaClock
from openrois_streaming.liveness import Verdict
from openrois_streaming.peer.arrival import Arrival
from openrois_streaming.receive.figures import ReceiverFigures
from openrois_streaming.source.source import MediaSource
from openrois_streaming.source.uplink_sink import UplinkSelector


class Reception(Protocol):
    """What receives one m-section; see `openrois_streaming.receive`."""

    @property
    def source(self) -> MediaSource[Any]:
        """What arrives, decoded while it is open."""
        ...

    @property
    def frames(self) -> int:
        """Whole frames that arrived so far, decoded or not."""
        ...

    @property
    def last_frame_at(self) -> float | None:
        """When the last of them came, on the media clock."""
        ...

    @property
    def figures(self) -> ReceiverFigures:
        """What was counted of its packets so far."""
        ...

    def pass_media(self, wanted: bool) -> None:
        """Whether packets are looked at; those that are not wanted are dropped unread."""
        ...


class Uplink:
    """One way of a stream into the engine. It is plugged in while there is a media path, suspended or not."""

    def __init__(self, reception: Reception, intake: UplinkSelector, clock: MediaClock) -> None:
        self._reception = reception
        self._intake = intake
        self._clock = clock
        self._arrival = Arrival()
        self._there = False
        self._open = False
        self._frames_before, self._before = reception.frames, reception.figures
        reception.pass_media(False)

    @property
    def frames(self) -> int:
        """Whole frames that arrived so far, decoded or not."""
        return self._reception.frames - self._frames_before

    @property
    def figures(self) -> ReceiverFigures:
        """What was counted of its packets so far."""
        return self._reception.figures.since(self._before)

    def follow(self, *, there: bool, wanted: bool) -> None:
        """`there`: whether the application can send over this way; `wanted`: whether it shall."""
        if there is not self._there:
            self._there = there
            if there:
                self._intake.add(self._reception.source)
            else:
                self._intake.remove(self._reception.source)
        opened = there and wanted
        if opened is not self._open:
            self._open = opened
            self._reception.pass_media(opened)
            if opened:
                self._arrival.opened(self._clock.now())
            else:
                self._arrival.closed()

    def judge(self, now: float) -> Verdict:
        """Whether media arrives; a way by which it does is plugged in."""
        verdict = self._arrival.judge(now, self._reception.last_frame_at)
        if self._there:
            self._intake.heard(self._reception.source, plays=verdict is Verdict.FLOWING)
        return verdict

    def close(self) -> None:
        """It is over."""
        self.follow(there=False, wanted=False)
