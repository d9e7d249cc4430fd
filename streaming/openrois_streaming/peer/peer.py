"""Peer connection to one application: its negotiation, its streams, and the liveness of the other end."""

import asyncio
import logging
from collections.abc import Sequence
from functools import partial
from typing import Protocol

from openrois_signaling.messages import Answer, Bye, Candidate, CaptureClocks, Downward, IceServer
from openrois_signaling.negotiation import Negotiation, Verdict

from openrois_streaming.clock import MediaClock
from openrois_streaming.errors import (
    InvalidCandidate,
    InvalidDescription,
    NoPath,
    PeerClosed,
    SessionError,
    StaleGeneration,
    TooManyCandidates,
    UnexpectedAnswer,
    UnknownPeer,
)
from openrois_streaming.liveness import Verdict as Progress
from openrois_streaming.liveness import Viewer
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.network.turns import Ingress
from openrois_streaming.peer.connection import BundledConnection
from openrois_streaming.peer.input_channels import InputPath, MakeChannels
from openrois_streaming.peer.section import StreamPath
from openrois_streaming.peer.stream import Stream
from openrois_streaming.tasks import OwnedTasks, Task

CONNECT_TIMEOUT = 15.0
"""Seconds from the first answer in place until media can pass."""

CLOCKS_INTERVAL = 5.0
"""Seconds after which the application is sent new capture clocks: this machine's clock may have been set."""

_log = logging.getLogger(__name__)


class PeerOwner(Protocol):
    """Owner of a peer connection, which is notified. All calls are made in the event loop and must not block."""

    def peer_says(self, message: Downward) -> None:
        """Send `message` to the application."""
        ...

    def peer_answered(self) -> None:
        """Note that an answer was applied."""
        ...

    def peer_changed(self, peer: "Peer") -> None:
        """Note that media can pass over more of the peer than before."""
        ...

    def peer_declined(self, peer: "Peer", stream: Stream) -> None:
        """Detach `stream`, which the application declines or which cannot be sent."""
        ...

    def peer_ended(self, peer: "Peer") -> None:
        """Note that the peer has ended for good, and that its bye was sent."""
        ...

    def peer_muted(self, reason: str) -> None:
        """Note that the peer has lost its input channels, though it goes on."""
        ...


class Peer:
    """Peer connection `peer_id`, which replaces the peer `replaces` if that is given.

    `tick` must be called several times a second. Its tasks belong to `tasks`.
    """

    def __init__(
        self,
        peer_id: str,
        *,
        replaces: str | None,
        ice_servers: Sequence[IceServer],
        network: NetworkSettings,
        guarded: GuardFigures,
        ingress: Ingress,
        clock: MediaClock,
        tasks: OwnedTasks,
        owner: PeerOwner,
        channels: MakeChannels,
    ) -> None:
        self.peer_id = peer_id
        self.stream_paths: dict[Stream, StreamPath] = {}
        self.viewer: Viewer | None = None
        """The viewer at the other end; None until media can pass."""
        self._clock = clock
        self._tasks = tasks
        self._owner = owner
        self._negotiation = Negotiation(peer_id, replaces)
        self._connection = BundledConnection(
            ice_servers,
            network,
            guarded,
            ingress,
            clock,
            clock.wall() - clock.now(),
            self._connection_is,
            self._sign_of_life,
            self._send_candidate,
        )
        self.input = InputPath(
            partial(self._connection.open_channels, channels),
            self._renegotiate,
            lambda: owner.peer_muted("the application closed its data channels"),
        )
        """Operator input, available after the first stream."""
        self._answered_at: float | None = None
        self._clocks_sent: tuple[str, ...] = ()
        self._clocks_due = 0.0
        self._work: Task[object] | None = None
        self.ended = False
        """Whether the peer has ended for good."""
        self.reason = ""
        """Why the peer has ended."""
        self._closing: Task[None] | None = None

    def attach(self, stream: Stream) -> None:
        """Give `stream` a section; an offer follows.

        Raises:
            TooManySections: there is no section to spare.
            PeerClosed: the application has closed the peer connection.
        """
        section = self._connection.section_for(stream)
        section.stream_path = self.stream_paths[stream] = StreamPath(stream, section, self._tasks, self._clock)
        self._renegotiate()

    def detach(self, stream: Stream) -> None:
        """Stop `stream`, at once; its section becomes idle with the next offer."""
        path = self.stream_paths.pop(stream, None)
        if path is None:
            return
        path.close()
        path.section.stream_path = None
        if not self.ended:
            self._renegotiate()

    def follow(self) -> None:
        """Send and receive as the phases of the streams demand now."""
        connected = self.viewer is not None and not self.ended
        for path in self.stream_paths.values():
            path.up = connected and path.listed_by(self._negotiation.answered)
            path.follow()

    def judge(self, stream: Stream, now: float) -> Progress | None:
        """Judge `stream` on this peer; None if it has no media path here."""
        path = self.stream_paths.get(stream)
        if path is None or not path.up or self.viewer is None:
            return None
        return path.judge(now, self.viewer.seen)

    async def apply_answer(self, answer: Answer) -> None:
        """Apply an answer, completely even if the caller is cancelled.

        Raises:
            UnknownPeer: the peer has ended.
            UnexpectedAnswer: no offer waits for it; it is dropped.
            InvalidDescription: it cannot be used; the peer has ended for good.
        """
        verdict = self._negotiation.receive_answer(answer, self._clock.now())
        if verdict is Verdict.ENDED:
            raise UnknownPeer("the peer connection has ended")
        if verdict is Verdict.STALE:
            raise UnexpectedAnswer(self._negotiation.why_stale(answer))
        work = self._work = self._tasks.start(self._apply(answer.sdp), f"answer {answer.generation}")
        await asyncio.wait({work})
        refusal = UnknownPeer("the peer connection has ended") if work.cancelled() else work.result()
        if refusal is not None:
            raise refusal

    async def add_candidate(self, candidate: Candidate) -> None:
        """Add a candidate of the application, now or once its answer is applied.

        The end of candidates is not passed on: aiortc would give up as soon as the known candidates have failed,
        although a browser that hides its addresses is found only by its own checks.

        Raises:
            UnknownPeer: the peer has ended.
            StaleGeneration: it is of another generation than the present one.
            TooManyCandidates: the limit of the peer is reached.
            InvalidCandidate: it cannot be used.
        """
        verdict = self._negotiation.candidate(candidate)
        if verdict is Verdict.ENDED:
            raise UnknownPeer("the peer connection has ended")
        if verdict is Verdict.STALE:
            raise StaleGeneration(f"a candidate of generation {candidate.generation} belongs to another offer")
        if verdict is Verdict.FULL:
            raise TooManyCandidates("the peer connection has reached its limit of candidates: restart it")
        if candidate.candidate:
            await self._connection.add_candidate(candidate.candidate, only_check=verdict is Verdict.HELD)

    def tick(self, now: float, late: float = 0.0) -> None:
        """Check deadlines and signs of life at the time `now`; `late` seconds before it do not count."""
        if self.ended:
            return
        if late:
            self._negotiation.excuse(late, now)
            if self._answered_at is not None:
                self._answered_at = min(now, self._answered_at + late)
        bye = self._negotiation.expire(now)
        if bye is not None:
            self._finish(bye)
        elif self._connection.sender_failed:
            self.end_connection("a sender has failed")
        elif misuse := self._connection.misuse:
            _log.info("a peer connection is ended: %s", misuse)
            self.end_connection(misuse)
        elif self.viewer is None:
            if self._answered_at is not None and now - self._answered_at >= CONNECT_TIMEOUT:
                self.end_connection("no media path to the application was found")
        else:
            self._tick_paths(now)
            self._send_capture_clocks(now)
            self.viewer.excuse(late)
            self._watch(self.viewer, now)

    def _tick_paths(self, now: float) -> None:
        for stream, path in tuple(self.stream_paths.items()):
            path.tick(now)
            if path.refused:
                _log.warning("the stream %s ends: %s", stream.stream_id, path.refused)
                self._owner.peer_declined(self, stream)

    def end_connection(self, reason: str) -> None:
        """End the peer for good. The application is sent a bye with `reason`; closing goes on in a task."""
        bye = self._negotiation.end_negotiation(reason)
        if bye is not None:
            self._finish(bye)

    @property
    def is_closed(self) -> bool:
        """Whether the peer has ended and aiortc has closed it."""
        return self._closing is not None and self._closing.done()

    async def closed(self) -> None:
        """Wait until the ended peer is closed, which takes a bounded time."""
        assert self._closing is not None, "a peer connection is closed when it has ended"
        await asyncio.wait({self._closing})

    def _renegotiate(self) -> None:
        if self._negotiation.change(self._clock.now()):
            self._work = self._tasks.start(self._offer(), "offer")

    async def _offer(self) -> None:
        try:
            self._negotiation.describe()
            sdp, streams = await self._connection.describe(self._negotiation.generation + 1)
            offer = self._negotiation.made(sdp, streams, self._clock.now())
        except (NoPath, PeerClosed) as refusal:
            self.end_connection(str(refusal))
        except Exception:
            _log.exception("no offer could be made")
            self.end_connection("no offer could be made")
        else:
            self._owner.peer_says(offer)

    async def _apply(self, sdp: str) -> SessionError | None:
        """Apply an answer; returns its refusal, which ends the peer, as it may be half applied."""
        try:
            candidates = await self._connection.apply(sdp)
        except InvalidDescription as refusal:
            _log.info("an answer was refused: %s (%r)", refusal, type(refusal.__cause__))
            self.end_connection(str(refusal))
            return refusal
        held = self._negotiation.applied(self._clock.now())
        if self._answered_at is None:
            self._answered_at = self._clock.now()
            self._owner.peer_answered()
        for attribute in (*candidates, *(each.candidate for each in held if each.candidate)):
            try:
                await self._connection.add_candidate(attribute)
            except InvalidCandidate:
                _log.debug("a candidate cannot be used")
        self._detach_declined()
        self.follow()
        if self.viewer is None:
            for path in self.stream_paths.values():
                path.prepare()
        self._owner.peer_changed(self)
        if self._negotiation.dirty:
            self._renegotiate()
        return None

    def _detach_declined(self) -> None:
        """Detach the streams that the application has declined in its answer."""
        for stream, path in tuple(self.stream_paths.items()):
            answered = path.section.answered
            if path.listed_by(self._negotiation.answered) and answered != stream.direction:
                text = "the application answers %s to the %s stream %s"
                _log.info(text, answered, stream.direction, stream.stream_id)
                if path.declined:
                    self._owner.peer_declined(self, stream)

    def _send_candidate(self, candidate: str | None) -> None:
        """Send a candidate of this end that was found after the offer."""
        if not self.ended:
            mid = self._connection.sections[0].mid if candidate else None
            message = Candidate(
                peer_id=self.peer_id, generation=self._negotiation.generation, candidate=candidate, sdp_mid=mid
            )
            self._owner.peer_says(message)

    def _connection_is(self, state: str) -> None:
        if self.ended:
            return
        if state == "connected" and self.viewer is None:
            self.viewer = Viewer(self._clock.now())
            self.follow()
            self._send_capture_clocks(self._clock.now())
            self._owner.peer_changed(self)
        elif state == "failed":
            self.end_connection("the media path to the application was lost")
        elif state == "closed":
            self.end_connection("the application closed the peer connection")

    def _send_capture_clocks(self, now: float) -> None:
        """Send capture clocks: for new senders at once, for the same ones every `CLOCKS_INTERVAL`."""
        clocks = tuple(
            clock for clock in (path.capture_clock() for path in self.stream_paths.values()) if clock is not None
        )
        mids = tuple(clock.mid for clock in clocks)
        if not clocks or (mids == self._clocks_sent and now < self._clocks_due):
            return
        self._clocks_sent, self._clocks_due = mids, now + CLOCKS_INTERVAL
        self._owner.peer_says(CaptureClocks(peer_id=self.peer_id, senders=clocks))

    def _watch(self, viewer: Viewer, now: float) -> None:
        if viewer.gone(now):
            self.end_connection("the viewer is gone")
            return
        waiting = any(self.judge(stream, now) is Progress.UNANSWERED for stream in self.stream_paths)
        if viewer.ask(now, urgent=waiting):
            self._tasks.start(self._connection.ask_for_a_sign(), "ask for a sign of life")

    def _sign_of_life(self) -> None:
        if self.viewer is not None:
            self.viewer.alive(self._clock.now())

    def _finish(self, bye: Bye) -> None:
        self.ended = True
        self.reason = bye.reason
        self.input.close()
        if self._work is not None and self._work is not asyncio.current_task():
            self._work.cancel()
        self.follow()
        self._closing = self._tasks.start(self._close(), "close")
        self._owner.peer_says(bye)
        self._owner.peer_ended(self)

    async def _close(self) -> None:
        if self._work is not None:
            await asyncio.wait({self._work})
        await self._connection.close()
