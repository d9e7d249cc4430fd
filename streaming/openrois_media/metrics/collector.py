"""Collector of figures from every session, rendition and source of the adapter, in its event loop."""

import asyncio
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict

from openrois_streaming.clock import MediaClock
from openrois_streaming.errors import UnknownStream
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.publish.publisher import Publishing
from openrois_streaming.session.session import StreamSession
from openrois_streaming.session.sessions import StreamSessions
from openrois_streaming.stats import StreamStats

from openrois_media.metrics.figures import FigureGroup, Process, Snapshot, Source
from openrois_media.supervision import Supervised
from openrois_media.visitors.figures import VisitorFigures

__all__ = ["Collector"]


class Collector:
    """Collector of an adapter's figures.

    Args:
        sessions: the stream sessions.
        publishers: the publishers, by the name of the source.
        sources: the supervised sources, by name.
        guarded: counts of dropped datagrams.
        clock: the media clock.
        more: returns the figures of the adapter beside streaming.
        visitors: returns the counts of visitors; None where they are not told apart.
    """

    def __init__(
        self,
        sessions: StreamSessions,
        publishers: Mapping[str, Publishing],
        sources: dict[str, Supervised],
        guarded: GuardFigures,
        clock: MediaClock,
        more: Callable[[], tuple[FigureGroup, ...]] = tuple,
        visitors: Callable[[], VisitorFigures | None] = lambda: None,
    ) -> None:
        self._sessions = sessions
        self._publishers = publishers
        self._sources = sources
        self._guarded = guarded
        self._clock = clock
        self._more = more
        self._visitors = visitors

    async def snapshot(self) -> Snapshot:
        """Return all present figures."""
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
        found = tuple(each for session in streams for each in session)
        return Snapshot(process, sources, renditions, found, guarded, self._more(), self._visitors())

    def _source(self, name: str, supervised: Supervised) -> Source:
        seen = supervised.observe()
        age = None if seen.last_frame_at is None else max(0.0, self._clock.now() - seen.last_frame_at)
        publisher = self._publishers.get(name)
        encoders = None if publisher is None else publisher.running_encoders
        return Source(name, supervised.health.status, seen.frames, age, encoders)


async def _streams_of(session: StreamSession) -> Sequence[StreamStats]:
    found = []
    for stream_id in session.stream_ids:
        with suppress(UnknownStream):  # it ended while others were read
            found.append(await session.stats(stream_id))
    return found
