"""The peer connection of a session, and while it is being replaced, the one before it."""

from collections.abc import Callable
from typing import TypeAlias

from openrois_signaling.messages import Downward

from openrois_streaming.errors import PeerClosed, TooManySections, UnknownPeer
from openrois_streaming.liveness import Verdict
from openrois_streaming.peer.input_channels import InputSink, SessionInput
from openrois_streaming.peer.peer import Peer, PeerOwner
from openrois_streaming.peer.section import StreamPath
from openrois_streaming.peer.stream import Stream, StreamTable

REPLACE_TIMEOUT = 5.0
"""Seconds that a connected replacement has to play everything before the one it replaces is closed."""

MakePeer: TypeAlias = Callable[[str | None, PeerOwner], Peer]
"""Makes a peer connection that replaces another or none, and tells its owner."""


class Peers:
    """At most two peer connections: the present one and, until that plays, the one it replaces.

    When the present one ends, the streams go back to the one before if that is still there, or end with it. `send` gets
    offers, candidates and byes; `on_change` is called whenever it is worth to look at the streams; `sink` hears what a
    person does.
    """

    def __init__(
        self,
        streams: StreamTable,
        make: MakePeer,
        send: Callable[[Downward], None],
        on_change: Callable[[], None],
        sink: InputSink | None = None,
    ) -> None:
        self._streams = streams
        self._make = make
        self._send = send
        self._on_change = on_change
        self._present: Peer | None = None
        self._replaced: Peer | None = None
        self._closing: list[Peer] = []
        self.was_answered = False
        """Whether the application has ever answered an offer."""
        self.input = SessionInput(sink, lambda: [peer.input for peer in self.all()])
        """For what a person does."""

    def all(self) -> tuple[Peer, ...]:
        """Those that have not ended, the present one first."""
        return tuple(peer for peer in (self._present, self._replaced) if peer is not None)

    def find(self, peer_id: str) -> Peer:
        """The one of that id. Raises UnknownPeer."""
        for peer in self.all():
            if peer.peer_id == peer_id:
                return peer
        raise UnknownPeer("there is no such peer connection")

    def attach(self, stream: Stream) -> None:
        """Play `stream` over the present one, which is made if there is none. Raises TooManySections."""
        while True:
            if self._present is None:
                self._present = self._make(None, self)
            try:
                self._present.attach(stream)
            except PeerClosed as closed:
                self._present.end(str(closed))
            else:
                return self.input.follow()

    def detach(self, stream: Stream) -> None:
        """Play `stream` no more."""
        for peer in self.all():
            peer.detach(stream)

    def follow(self) -> None:
        """Send what is to be sent now, and nothing else."""
        for peer in self.all():
            peer.follow()

    def leg(self, stream: Stream) -> StreamPath:
        """The way of `stream` over the present one."""
        assert self._present is not None, "a stream ends with its last peer connection"
        return self._present.legs[stream]

    @property
    def round_trip_time(self) -> float | None:
        """Seconds there and back, as the viewer's reports on what it is sent now have it; None where there are none.

        Until something is known of the present one, that of the one before counts.
        """
        for peer in self.all():
            reports = [leg.report for stream, leg in peer.legs.items() if stream.is_open and leg.report is not None]
            measured = [each.round_trip_time for each in reports if each.round_trip_time is not None]
            if measured:
                return max(measured)
        return None

    def verdicts(self, stream: Stream, now: float) -> list[Verdict]:
        """What was measured about `stream` on each media path it has."""
        judged = (peer.judge(stream, now) for peer in self.all())
        return [verdict for verdict in judged if verdict is not None]

    def restart(self, peer_id: str) -> str:
        """Replace `peer_id` by a new one; returns its id. Does nothing while it is being replaced already.

        Raises:
            UnknownPeer: there is no such peer connection, or it has no stream left to carry; then it ends.
        """
        peer = self.find(peer_id)
        if not tuple(self._streams):
            self.end("there is no stream to carry")
            raise UnknownPeer("the peer connection has no stream to carry")
        if peer is self._present:
            if self._replaced is not None:
                self._replaced.end("it was replaced")
            self._replaced = peer
            self._present = self._make(peer_id, self)
            for stream in self._streams:
                self._present.attach(stream)
            self.input.follow()
        assert self._present is not None, "there is a present one while there is any"
        return self._present.peer_id

    def tick(self, now: float, late: float) -> None:
        """Judge all deadlines at the time `now`; for `late` seconds before, nobody listened."""
        for peer in self.all():
            peer.tick(now, late)
        present, replaced = self._present, self._replaced
        if present is None or replaced is None or present.viewer is None:
            return
        plays = all(present.judge(stream, now) is Verdict.FLOWING for stream in self._streams if stream.is_open)
        if plays or now - present.viewer.since >= REPLACE_TIMEOUT:
            replaced.end("it was replaced")

    def end(self, reason: str) -> None:
        """End them all."""
        for peer in reversed(self.all()):  # the present one last: its streams must not fall back to the other
            peer.end(reason)

    async def closed(self) -> None:
        """Wait until all that have ended are closed, which takes a bounded time."""
        for peer in self._closing:
            await peer.closed()

    def peer_says(self, message: Downward) -> None:
        """`message` is for the application."""
        self._send(message)

    def peer_answered(self) -> None:
        """An answer was applied."""
        self.was_answered = True

    def peer_changed(self, peer: Peer) -> None:
        """Media can pass over more of `peer` than before."""
        self._on_change()

    def peer_declined(self, peer: Peer, stream: Stream) -> None:
        """The application wants nothing of `stream`, which ends."""
        self.detach(stream)
        self._streams.end(stream)

    def peer_muted(self, reason: str) -> None:
        """What a person does cannot come over one of them any more."""
        self.input.lost(reason)

    def peer_ended(self, peer: Peer) -> None:
        """`peer` has ended."""
        self._closing = [each for each in self._closing if not each.is_closed] + [peer]
        if peer is self._replaced:
            self._replaced = None
        else:
            self._present, self._replaced = self._replaced, None
            for stream in self._streams:
                self._fall_back(stream)
        self.input.lost(peer.reason)
        self._on_change()

    def _fall_back(self, stream: Stream) -> None:
        if stream.stream_id not in self._streams:
            return  # it ended with the peer connection that another one could not fall back to
        if self._present is None:
            self._streams.end(stream)
        elif stream not in self._present.legs:
            try:
                self._present.attach(stream)
            except TooManySections:
                self._streams.end(stream)
            except PeerClosed as closed:
                self._present.end(str(closed))
