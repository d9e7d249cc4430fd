"""What one application plays: its streams, over one peer connection."""

import logging
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Self

from openrois_signaling.messages import Answer, Bye, Candidate, IceServer, MediaKind, Offer

from openrois_streaming.clock import MediaClock
from openrois_streaming.feed import MediaPublisher
from openrois_streaming.peer import Peer, PeerOwner
from openrois_streaming.peers import Peers
from openrois_streaming.sdp import CandidatePolicy
from openrois_streaming.state import StreamInput, StreamStatus
from openrois_streaming.stats import Counters, StreamStats
from openrois_streaming.stream import Stream, StreamChange, StreamTable, choose_codecs
from openrois_streaming.tasks import OwnedTasks, Task

TICK = 0.1
"""Seconds between two looks at deadlines, signs of life and progress."""

LATE = 1.0
"""Seconds a look may be late before the delay counts as this process's own: it was stopped, or the machine slept."""

_log = logging.getLogger(__name__)


class StreamSession:
    """The streams of one application, as m-sections of one peer connection (of two while one replaces the other).

    To be used inside `async with`; leaving it ends everything. `send` gets offers and byes, `on_change` every change of
    a stream's status. Both are called in the event loop and must neither block nor raise. They are not called from
    within the methods that answer a request (so that the reply can go first), except that `answer` and `restart` may
    say bye to a peer connection that they end.

    Args:
        mint: makes a new peer id.
        ice_servers: for the peer connections that are made from now on; may be set at any time.
        policy: the addresses of the application that may be sent to.
        clock: for all deadlines.
        name: in logs and task names.
    """

    def __init__(
        self,
        *,
        mint: Callable[[], str],
        send: Callable[[Offer | Bye], None],
        on_change: Callable[[StreamChange], None],
        clock: MediaClock,
        ice_servers: Sequence[IceServer] = (),
        policy: CandidatePolicy | None = None,
        name: str = "session",
    ) -> None:
        self.ice_servers = tuple(ice_servers)
        self._clock = clock
        self._name = name
        self._tasks = OwnedTasks(name, self._failed)
        self._streams = StreamTable(on_change, clock)

        def make_peer(replaces: str | None, owner: PeerOwner) -> Peer:
            return Peer(
                mint(),
                replaces=replaces,
                ice_servers=self.ice_servers,
                policy=policy or CandidatePolicy(),
                clock=clock,
                tasks=self._tasks,
                owner=owner,
            )

        self._peers = Peers(self._streams, make_peer, send, self._look_soon)
        self._supervisor: Task[None] | None = None
        self._closed = False

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close("the session is over")

    @property
    def stream_ids(self) -> tuple[str, ...]:
        """The streams that have not ended."""
        return tuple(stream.stream_id for stream in self._streams)

    @property
    def peer_ids(self) -> tuple[str, ...]:
        """The peer connections that have not ended, the present one first."""
        return tuple(peer.peer_id for peer in self._peers.all())

    def connect(
        self,
        stream_id: str,
        component_ref: str,
        publisher: MediaPublisher,
        kind: MediaKind,
        codecs: Sequence[str] | None = None,
    ) -> None:
        """Add a stream towards the application; an offer follows.

        Args:
            stream_id: unique for ever.
            component_ref: whose stream it is.
            publisher: where its frames come from.
            kind: "video" or "audio".
            codecs: what the application can decode, as media types or their subtypes; None if it did not say.

        Raises:
            NoCommonCodec: it can decode nothing of what can be sent.
            TooManySections: the peer connection is full.
            ValueError: the session is closed, or has the stream already.
        """
        if self._closed or stream_id in self._streams:
            raise ValueError("a stream is connected once, and only to an open session")
        stream = Stream(stream_id, component_ref, kind, publisher, choose_codecs(kind, codecs), Counters())
        self._peers.attach(stream)
        self._streams.add(stream)
        if self._supervisor is None or self._supervisor.done():
            self._supervisor = self._tasks.start(self._supervise(), "supervisor")

    def suspend(self, stream_id: str) -> None:
        """Send nothing more of a stream until it is resumed. Suspending twice is fine. Raises UnknownStream."""
        self._gate(stream_id, StreamInput.SUSPEND)

    def resume(self, stream_id: str) -> None:
        """Send again, from a key frame on, without a negotiation. Resuming twice is fine. Raises UnknownStream."""
        self._gate(stream_id, StreamInput.RESUME)

    def disconnect(self, stream_id: str) -> None:
        """End a stream; an offer follows that makes its section idle. Raises UnknownStream."""
        stream = self._streams[stream_id]
        self._peers.detach(stream)
        self._streams.end(stream)
        self._look_soon()

    def status(self, stream_id: str) -> StreamStatus:
        """The status of a stream now. Raises UnknownStream."""
        return self._streams[stream_id].status

    async def stats(self, stream_id: str) -> StreamStats:
        """The figures of a stream now. Raises UnknownStream."""
        return await self._peers.leg(self._streams[stream_id]).stats()

    async def answer(self, answer: Answer) -> None:
        """Hand an answer to its peer connection; raises UnknownPeer and what `Peer.answer` raises."""
        await self._peers.find(answer.peer_id).answer(answer)

    async def candidate(self, candidate: Candidate) -> None:
        """Hand a candidate to its peer connection; raises UnknownPeer and what `Peer.candidate` raises."""
        await self._peers.find(candidate.peer_id).candidate(candidate)

    def restart(self, peer_id: str) -> str:
        """Make a new peer connection that replaces `peer_id`; an offer follows. Returns its id.

        The old one goes on until the new one plays. Streams keep their ids and stay suspended if they are. Asking again
        while it is being replaced changes nothing. Raises UnknownPeer.
        """
        return self._peers.restart(peer_id)

    async def close(self, reason: str) -> None:
        """End all streams and peer connections and wait until they are closed, for a few seconds at most."""
        self._closed = True
        self._peers.end(reason)
        self._streams.tell()
        await self._peers.closed()
        await self._tasks.aclose()

    def _gate(self, stream_id: str, event: StreamInput) -> None:
        self._streams[stream_id].apply(event)
        self._peers.follow()
        self._look_soon()

    async def _supervise(self) -> None:
        due = self._clock.now()
        while self._peers.all():
            now = self._clock.now()
            self._peers.tick(now, now - due if now - due > LATE else 0.0)
            await self._look()
            due = self._clock.now() + TICK
            await self._clock.sleep_until(due)

    def _look_soon(self) -> None:
        """Look at the streams before the next tick, but not within the present call."""
        if not self._closed:
            self._tasks.start(self._look(), "look")

    async def _look(self) -> None:
        """Judge every stream by what was measured, and tell what changed."""
        now = self._clock.now()
        for stream in self._streams:
            stream.judge(self._peers.verdicts(stream, now))
        self._streams.tell()

    def _failed(self, error: BaseException) -> None:
        _log.error("%s: an internal error ends it", self._name, exc_info=error)
        self._peers.end("an internal error of the engine")
        self._streams.tell()
