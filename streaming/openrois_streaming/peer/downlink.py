"""Downlink of one stream to its viewer: the choice of a rendition and rate, and the probing of higher rates."""

import asyncio
import logging
from collections import deque
from collections.abc import Awaitable, Callable, Collection
from contextlib import suppress
from math import inf
from statistics import median
from typing import Protocol

from openrois_streaming.adaptation.budget import BURST
from openrois_streaming.adaptation.rung import Rung
from openrois_streaming.adaptation.viewer import Adaptation, Decision, Standing
from openrois_streaming.clock import MediaClock
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.errors import NoEncoder
from openrois_streaming.peer.stream import Stream
from openrois_streaming.publish.rendition_feed import STILL_INTERVAL, RenditionFeed, SharedRendition
from openrois_streaming.rtp.reports import ReceiverReport
from openrois_streaming.stats import AdaptationStats
from openrois_streaming.tasks import OwnedTasks, Task

PREPARATION = 1.0
"""Seconds for which source and encoder run at most for a viewer that has answered and has no media path yet."""

# Measurements of the path's own round trip, and the pause between them, where it is busy.
_TRIPS = 4
_PAUSE = 0.05
# Packets that measure one round trip.
_AT_ONCE = 4
# Greatest length of a burst, in seconds.
_LONGEST_BURST = 0.3
# Queueing delay of a path that is not busy, in seconds.
_STILL = 0.02
_REPETITIONS = 4
# Seconds without a tick after which this process counts as having stood still.
_LATE = 0.3

_log = logging.getLogger(__name__)


def _burst(trips: Collection[float]) -> float:
    """Return the length of a burst, in seconds, that stands out among the latest round trips, which vary by chance.

    A standing queue makes all of them longer, and does not lengthen the burst.
    """
    usual = median(trips)
    return BURST if usual == inf else min(BURST + 2 * (usual - min(trips)), _LONGEST_BURST)


class MediaSender(Protocol):
    """Sender of frames to one viewer."""

    def send(self, frame: EncodedFrame) -> None:
        """Send a frame; never blocks and never raises."""
        ...

    def pad(self, octets: int) -> int:
        """Send about so many bytes of padding at once; returns how many."""
        ...


class Downlink:
    """Downlink that plays a stream to its viewer while it is open, and adapts to the viewer's path.

    Args:
        stream: the stream, which has a publisher.
        sender: sends its frames.
        tasks: run the players of renditions.
        clock: times all decisions.
        round_trip: measures the round trip behind all that was sent before, in seconds; None if unknown.
    """

    def __init__(
        self,
        stream: Stream,
        sender: MediaSender,
        tasks: OwnedTasks,
        clock: MediaClock,
        round_trip: Callable[[], Awaitable[float | None]],
    ) -> None:
        assert stream.publisher is not None, "a downlink needs a stream with a publisher"
        self._publisher = stream.publisher
        self._stream = stream
        self._sender = sender
        self._clock = clock
        self._tasks = tasks
        self._round_trip = round_trip
        self._measuring: Task[None] | None = None
        self._asked = asyncio.Event()
        self._feed = RenditionFeed(stream.kind, sender.send, stream.counters, tasks, clock)
        self._ticked = clock.now()
        self._codec: str | None = None
        self._preparing: Task[None] | None = None
        self._failing = False
        self.refused = ""
        """Why the stream cannot be sent for good; empty if it can."""
        self._rung: Rung | None = None
        self._demand = 0.0
        self.adaptation = Adaptation(stream.caps, clock.now(), stream.path_bitrate)

    @property
    def is_open(self) -> bool:
        """Whether the stream is played."""
        return self._codec is not None

    @property
    def pause(self) -> float:
        """Intended seconds between two pictures where single pictures are sent; else 0."""
        return STILL_INTERVAL if self._feed.stills else 0.0

    def prepare(self, codec: str) -> None:
        """Run source and encoder once for `PREPARATION`, so that the first picture need not wait for them."""
        if self._preparing is None and self._stream.kind == "video":
            self._preparing = self._tasks.start(self._run_ahead(codec), "prepare")

    def open(self, codec: str) -> None:
        """Play the stream in `codec`, a media type."""
        self._codec = codec
        if self._stream.kind == "video":
            self._measuring = self._tasks.start(self._measure(), "measure")
        self.tick(self._clock.now())

    def close(self) -> None:
        """Stop playing."""
        self._codec = None
        self._feed.close()
        if self._measuring is not None:
            self._measuring.cancel()
            self._measuring = None

    def tick(self, now: float) -> None:
        """Decide anew which rendition is sent, at which rate."""
        self._notice_stall(now)
        self._ticked = now
        if self._codec is None:
            return
        if self._feed.rendition is not None and self.adaptation.path.doubtful(now):
            # The present rendition goes on until the doubt is resolved; a viewer without one does not wait.
            return
        try:
            self._decide(self._codec, now)
            self._failing = False
        except NoEncoder as refusal:
            self.refused = str(refusal)
        except Exception as error:
            if not self._failing:
                _log.warning("a %s stream cannot be played: %r", self._stream.kind, error)
            self._failing = True

    def repair(self) -> None:
        """Request a key frame for the viewer."""
        self._feed.repair()

    def sent(self, frame: EncodedFrame) -> None:
        """Note that the sender has sent `frame`."""
        if self._preparing is not None:
            self._preparing.cancel()
        self.adaptation.path.sent(len(frame.data), self._clock.now())

    def reported(self, report: ReceiverReport) -> None:
        """Apply a receiver report; while the stream is closed, it says nothing of the path."""
        if not self.is_open:
            return
        now = self._clock.now()
        self._notice_stall(now)
        self.adaptation.path.reported(report, report.latest_round_trip, now)
        self._see_to_doubt(now)

    def estimated(self, bitrate: int) -> None:
        """Apply the viewer's estimate of its path, in bit/s; while the stream is closed, it says nothing."""
        if not self.is_open:
            return
        now = self._clock.now()
        self._notice_stall(now)
        self.adaptation.path.estimated(bitrate, now)
        self._see_to_doubt(now)

    def figures(self) -> AdaptationStats | None:
        """Return the last decision; None for a source with one rendition."""
        rung, path = self._rung, self.adaptation.path
        if rung is None:
            return None
        return AdaptationStats(
            width=rung.width,
            height=rung.height,
            frame_rate=rung.frame_rate,
            bitrate=round(self._demand),
            path=round(path.budget),
            estimate=None if path.estimate is None else round(path.estimate),
            probing=path.question is not None,
            switches=self.adaptation.switches,
        )

    async def _run_ahead(self, codec: str) -> None:
        with suppress(Exception):  # a failure will recur, and be reported, when the stream is played
            rendition, _ = self._choose(codec, self._clock.now())
            async with rendition.prepare():
                await self._clock.sleep_until(self._clock.now() + PREPARATION)

    async def _measure(self) -> None:
        """Measure, whenever a probe is due, how late a packet is behind a burst."""
        path = self.adaptation.path
        trips = deque([await self._trip() for _ in range(_TRIPS)], 2 * _TRIPS)
        least = min(trips)
        while True:
            await self._asked.wait()
            least = await self._check(least)
            if path.question is None:
                self._asked.clear()
                continue
            for _ in range(_TRIPS):
                # Packets that wait already are not of the burst.
                trip = await self._trip()
                trips.append(trip)
                least = min(least, trip)
                if trip - least < _STILL:
                    break
                await self._clock.sleep_until(self._clock.now() + _PAUSE)
            path.burst(self._clock.now())
            octets = self._pad(round((path.question or 0.0) * _burst(trips) / 8))
            trip = await self._trip()
            path.answered(octets * 8, None if trip == inf else trip - least, self._clock.now())
            self._asked.clear()
            self.tick(self._clock.now())

    async def _check(self, least: float) -> float:
        """Check for a queue, while a complaint of one is in doubt; returns the shortest trip by now."""
        path = self.adaptation.path
        while path.doubtful(self._clock.now()):
            trip = await self._trip()
            least = min(least, trip)
            if trip == inf:
                break
            path.checked(trip - least, self._clock.now())
        return least

    def _see_to_doubt(self, now: float) -> None:
        if self.adaptation.path.doubtful(now):
            self._asked.set()

    def _notice_stall(self, now: float) -> None:
        """Note a pause of this process, in which packets have waited here."""
        if now - self._ticked > _LATE:
            self._ticked = now
            self.adaptation.path.stalled(now)

    def _pad(self, wanted: int) -> int:
        """Send a burst; early, the few packets that can be sent again are repeated several times."""
        sent = 0
        for _ in range(_REPETITIONS):
            sent += self._sender.pad(wanted - sent)
            if sent >= wanted:
                break
        return sent

    async def _trip(self) -> float:
        """Return the shortest of several concurrent round trips, which leaves out delays by chance."""
        trips = await asyncio.gather(*(self._round_trip() for _ in range(_AT_ONCE)))
        return min((trip for trip in trips if trip is not None), default=inf)

    def _choose(self, codec: str, now: float) -> tuple[SharedRendition, Decision | None]:
        """Return the rendition to play, and the decision; None for a source with one rendition."""
        renditions = self._publisher.renditions(codec, self._stream.caps.fps)
        standings = [Standing(each.rung, each.least(self._feed)) for each in renditions if each.rung is not None]
        if not standings:
            return renditions[0], None
        decision = self.adaptation.decide(standings, now)
        return renditions[decision.index], decision

    def _decide(self, codec: str, now: float) -> None:
        rendition, decision = self._choose(codec, now)
        if decision is None:
            self._feed.play(rendition)
            return
        self._rung, self._demand = rendition.rung, decision.demand
        self._stream.path_bitrate = self.adaptation.path.budget
        self._feed.stills = decision.stills
        self._feed.play(rendition, decision.demand)
        if self.adaptation.path.question is not None and self._stream.counters.frames_sent:
            self._asked.set()
