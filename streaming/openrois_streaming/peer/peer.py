"""One peer connection to one application: its negotiation, its streams, and whether the other end is still there."""

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
"""Seconds after which the application is told anew when what it receives was captured: the clock may have been set."""

_log = logging.getLogger(__name__)


class PeerOwner(Protocol):
    """Who hears of a peer connection. All calls are made in the event loop and must not block."""

    def peer_says(self, message: Downward) -> None:
        """`message` is for the application."""
        ...

    def peer_answered(self) -> None:
        """An answer was applied."""
        ...

    def peer_changed(self, peer: "Peer") -> None:
        """Media can pass over more of it than before."""
        ...

    def peer_declined(self, peer: "Peer", stream: Stream) -> None:
        """The application wants nothing of `stream` here, or can be sent nothing: it is to be detached."""
        ...

    def peer_ended(self, peer: "Peer") -> None:
        """It has ended for good, and its bye is said."""
        ...

    def peer_muted(self, reason: str) -> None:
        """What a person does cannot come over one of its peer connections any more, though that goes on."""
        ...


class Peer:
    """A peer connection by the name of `peer_id`, which takes the place of `replaces` if that is given.

    `tick` must be called several times a second. What it starts belongs to `tasks`.
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
        self.legs: dict[Stream, StreamPath] = {}
        self.viewer: Viewer | None = None
        """The other end; None until media can pass."""
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
            self._found,
        )
        self.input = InputPath(
            partial(self._connection.open_channels, channels),
            self._renegotiate,
            lambda: owner.peer_muted("the application closed its data channels"),
        )
        """For what a person does, after the first stream."""
        self._answered_at: float | None = None
        self._clocks_told: tuple[str, ...] = ()
        self._clocks_due = 0.0
        self._work: Task[object] | None = None
        self.ended = False
        """Whether it is over for good."""
        self.reason = ""
        """Why it has ended."""
        self._closing: Task[None] | None = None

    def attach(self, stream: Stream) -> None:
        """Give `stream` a section; an offer follows.

        Raises:
            TooManySections: there is no section to spare.
            PeerClosed: the application has closed it.
        """
        section = self._connection.section_for(stream)
        section.leg = self.legs[stream] = StreamPath(stream, section, self._tasks, self._clock)
        self._renegotiate()

    def detach(self, stream: Stream) -> None:
        """Stop `stream`, at once; its section becomes idle with the next offer."""
        leg = self.legs.pop(stream, None)
        if leg is None:
            return
        leg.close()
        leg.section.leg = None
        if not self.ended:
            self._renegotiate()

    def follow(self) -> None:
        """Pass what is to be passed now, and nothing else."""
        connected = self.viewer is not None and not self.ended
        for leg in self.legs.values():
            leg.up = connected and leg.listed_by(self._negotiation.answered)
            leg.follow()

    def judge(self, stream: Stream, now: float) -> Progress | None:
        """What was measured about `stream` here; None if it has no media path here."""
        leg = self.legs.get(stream)
        if leg is None or not leg.up or self.viewer is None:
            return None
        return leg.judge(now, self.viewer.seen)

    async def answer(self, answer: Answer) -> None:
        """Apply an answer. It is applied to its end also when the caller is cancelled.

        Raises:
            UnknownPeer: the peer has ended.
            UnexpectedAnswer: no offer waits for it; it was dropped.
            InvalidDescription: it cannot be used; the peer has ended for good.
        """
        verdict = self._negotiation.answer(answer, self._clock.now())
        if verdict is Verdict.ENDED:
            raise UnknownPeer("the peer connection has ended")
        if verdict is Verdict.STALE:
            raise UnexpectedAnswer(self._negotiation.why_stale(answer))
        work = self._work = self._tasks.start(self._apply(answer.sdp), f"answer {answer.generation}")
        await asyncio.wait({work})
        refusal = UnknownPeer("the peer connection has ended") if work.cancelled() else work.result()
        if refusal is not None:
            raise refusal

    async def candidate(self, candidate: Candidate) -> None:
        """Take a candidate of the application in, now or when its answer is in place.

        The end of candidates is not passed on: aiortc would give up as soon as the candidates it knows have failed,
        although a browser that hides its addresses is only found by its own checks.

        Raises:
            UnknownPeer: the peer has ended.
            StaleGeneration: its generation is not the present one.
            TooManyCandidates: the peer has had as many as it may.
            InvalidCandidate: it cannot be used.
        """
        verdict = self._negotiation.candidate(candidate)
        if verdict is Verdict.ENDED:
            raise UnknownPeer("the peer connection has ended")
        if verdict is Verdict.STALE:
            raise StaleGeneration(f"a candidate of generation {candidate.generation} is not awaited")
        if verdict is Verdict.FULL:
            raise TooManyCandidates("the peer connection has had all its candidates")
        if candidate.candidate:
            await self._connection.add_candidate(candidate.candidate, only_check=verdict is Verdict.HELD)

    def tick(self, now: float, late: float = 0.0) -> None:
        """Judge deadlines and signs of life at the time `now`; for `late` seconds before, nobody listened."""
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
            self.end("a sender has failed")
        elif misuse := self._connection.misuse:
            _log.info("a peer connection is ended: %s", misuse)
            self.end(misuse)
        elif self.viewer is None:
            if self._answered_at is not None and now - self._answered_at >= CONNECT_TIMEOUT:
                self.end("no media path to the application was found")
        else:
            self._tick_legs(now)
            self._tell_clocks(now)
            self.viewer.excuse(late)
            self._watch(self.viewer, now)

    def _tick_legs(self, now: float) -> None:
        for stream, leg in tuple(self.legs.items()):
            leg.tick(now)
            if leg.refused:
                _log.warning("the stream %s ends: %s", stream.stream_id, leg.refused)
                self._owner.peer_declined(self, stream)

    def end(self, reason: str) -> None:
        """End it for good. The application is told `reason`; closing goes on in a task."""
        bye = self._negotiation.end(reason)
        if bye is not None:
            self._finish(bye)

    @property
    def is_closed(self) -> bool:
        """Whether it has ended and aiortc has closed it."""
        return self._closing is not None and self._closing.done()

    async def closed(self) -> None:
        """Wait until it is closed, which takes a bounded time; it must have ended."""
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
            self.end(str(refusal))
        except Exception:
            _log.exception("no offer could be made")
            self.end("no offer could be made")
        else:
            self._owner.peer_says(offer)

    async def _apply(self, sdp: str) -> SessionError | None:
        """Apply an answer; returns why it was refused, which ends the peer: it may be half applied."""
        try:
            candidates = await self._connection.apply(sdp)
        except InvalidDescription as refusal:
            _log.info("an answer was refused: %s (%r)", refusal, type(refusal.__cause__))
            self.end(str(refusal))
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
        self._heed()
        self.follow()
        if self.viewer is None:
            for leg in self.legs.values():
                leg.prepare()
        self._owner.peer_changed(self)
        if self._negotiation.dirty:
            self._renegotiate()
        return None

    def _heed(self) -> None:
        """Let go of the streams of which the application has answered that it wants nothing."""
        for stream, leg in tuple(self.legs.items()):
            answered = leg.section.answered
            if leg.listed_by(self._negotiation.answered) and answered != stream.direction:
                told = "the application answers %s to the %s stream %s"
                _log.info(told, answered, stream.direction, stream.stream_id)
                if leg.declined:
                    self._owner.peer_declined(self, stream)

    def _found(self, candidate: str | None) -> None:
        """A candidate of this end was found after the offer."""
        if not self.ended:
            mid = self._connection.sections[0].mid if candidate else None
            told = Candidate(
                peer_id=self.peer_id, generation=self._negotiation.generation, candidate=candidate, sdp_mid=mid
            )
            self._owner.peer_says(told)

    def _connection_is(self, state: str) -> None:
        if self.ended:
            return
        if state == "connected" and self.viewer is None:
            self.viewer = Viewer(self._clock.now())
            self.follow()
            self._tell_clocks(self._clock.now())
            self._owner.peer_changed(self)
        elif state == "failed":
            self.end("the media path to the application was lost")
        elif state == "closed":
            self.end("the application closed the peer connection")

    def _tell_clocks(self, now: float) -> None:
        """Say when what is sent was captured: of other senders than before at once, of the same ones now and then."""
        clocks = tuple(clock for clock in (leg.capture_clock() for leg in self.legs.values()) if clock is not None)
        mids = tuple(clock.mid for clock in clocks)
        if not clocks or (mids == self._clocks_told and now < self._clocks_due):
            return
        self._clocks_told, self._clocks_due = mids, now + CLOCKS_INTERVAL
        self._owner.peer_says(CaptureClocks(peer_id=self.peer_id, senders=clocks))

    def _watch(self, viewer: Viewer, now: float) -> None:
        if viewer.gone(now):
            self.end("the viewer is gone")
            return
        waiting = any(self.judge(stream, now) is Progress.UNANSWERED for stream in self.legs)
        if viewer.ask(now, urgent=waiting):
            self._tasks.start(self._connection.ask_for_a_sign(), "ask for a sign of life")

    def _sign_of_life(self) -> None:
        if self.viewer is not None:
            self.viewer.alive(self._clock.now())

    def _finish(self, bye: Bye) -> None:
        self.ended = True
        self.reason = bye.reason
        self.input.end()
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
