"""Takes the snapshot: reads every session, rendition and source of the adapter, in its event loop."""

import asyncio
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, replace

from openrois_streaming.clock import MediaClock
from openrois_streaming.errors import UnknownStream
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.publish.publisher import Publishing
from openrois_streaming.session.session import StreamSession
from openrois_streaming.session.sessions import StreamSessions
from openrois_streaming.stats import StreamStats

from openrois_avatar.metrics.figures import Process, Snapshot, Source
from openrois_avatar.sensing.figures import SenseFigures
from openrois_avatar.supervision import Supervised
from openrois_avatar.teleoperation.seat import Seat

__all__ = ["Looking"]


class Looking:
    """What of an adapter is measured.

    Args:
        sessions: the applications and their streams.
        publishers: what is played, by the name of its source.
        sources: what is supervised, by the name of the source.
        guarded: what did not get in from the network.
        clock: the media clock.
        senses: what analyses something, by the name of the sense; None: nothing does.
        seat: who operates by hand; None: nobody can.
    """

    def __init__(
        self,
        sessions: StreamSessions,
        publishers: Mapping[str, Publishing],
        sources: dict[str, Supervised],
        guarded: GuardFigures,
        clock: MediaClock,
        senses: Mapping[str, SenseFigures] | None = None,
        seat: Seat | None = None,
    ) -> None:
        self._sessions = sessions
        self._publishers = publishers
        self._sources = sources
        self._guarded = guarded
        self._clock = clock
        self._senses = senses or {}
        self._seat = seat

    async def snapshot(self) -> Snapshot:
        """Everything as it is now."""
        streams = [await _streams_of(session) for session in self._sessions]
        process = Process(
            sessions=len(self._sessions),
            sessions_limit=self._sessions.rules.applications,
            tasks=len(asyncio.all_tasks()),
            threads=threading.active_count(),
            unanswered=self._sessions.unanswered,
            displaced=self._sessions.displaced,
        )
        renditions = tuple(
            (name, rendition.figures()) for name, publisher in self._publishers.items() for rendition in publisher.made
        )
        sources = tuple(self._source(name, supervised) for name, supervised in self._sources.items())
        guarded = tuple(asdict(self._guarded).items())
        senses = tuple((name, replace(figures)) for name, figures in self._senses.items())
        operated = () if self._seat is None else tuple(asdict(self._seat.figures).items())
        found = tuple(each for session in streams for each in session)
        return Snapshot(process, sources, renditions, found, guarded, senses, operated)

    def _source(self, name: str, supervised: Supervised) -> Source:
        seen = supervised.observe()
        age = None if seen.last_frame_at is None else max(0.0, self._clock.now() - seen.last_frame_at)
        publisher = self._publishers.get(name)
        encoders = None if publisher is None else publisher.running_encoders
        return Source(name, supervised.health.status, seen.frames, age, encoders)


async def _streams_of(session: StreamSession) -> Sequence[StreamStats]:
    found = []
    for stream_id in session.stream_ids:
        with suppress(UnknownStream):  # it ended while the others were asked
            found.append(await session.stats(stream_id))
    return found
