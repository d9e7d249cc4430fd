"""Peer connections of a session: the present one, and while it replaces another, that one."""

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
"""Factory of a peer connection that replaces another or none, and notifies its owner."""


class Peers:
    """Peer connections of a session, two at most: the present one and, until that plays, the one it replaces.

    When the present one ends, the streams go back to the replaced one if that is still there, or end with it. `send`
    gets offers, candidates and byes; `on_change` is called whenever the streams may have changed; `sink` gets operator
    input.
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
        """Operator input."""

    def all(self) -> tuple[Peer, ...]:
        """Return the peers that have not ended, the present one first."""
        return tuple(peer for peer in (self._present, self._replaced) if peer is not None)

    def find(self, peer_id: str) -> Peer:
        """Return the peer of that id. Raises UnknownPeer."""
        for peer in self.all():
            if peer.peer_id == peer_id:
                return peer
        raise UnknownPeer("there is no such peer connection")

    def attach(self, stream: Stream) -> None:
        """Play `stream` over the present peer, which is made if there is none. Raises TooManySections."""
        while True:
            if self._present is None:
                self._present = self._make(None, self)
            try:
                self._present.attach(stream)
            except PeerClosed as closed:
                self._present.end_connection(str(closed))
            else:
                return self.input.follow()

    def detach(self, stream: Stream) -> None:
        """Stop `stream` on all peers."""
        for peer in self.all():
            peer.detach(stream)

    def follow(self) -> None:
        """Send and receive as the phases of the streams demand now."""
        for peer in self.all():
            peer.follow()

    def path_of(self, stream: Stream) -> StreamPath:
        """Return the path of `stream` over the present peer."""
        assert self._present is not None, "a stream ends with its last peer connection"
        return self._present.stream_paths[stream]

    @property
    def round_trip_time(self) -> float | None:
        """Round-trip time in seconds by the viewer's newest reports on open streams; None without any.

        Before the first report on the present peer, that of the replaced one counts.
        """
        for peer in self.all():
            reports = [
                path.report for stream, path in peer.stream_paths.items() if stream.is_open and path.report is not None
            ]
            measured = [
                each.round_trip_time for each in reports if each is not None and each.round_trip_time is not None
            ]
            if measured:
                return max(measured)
        return None

    def verdicts(self, stream: Stream, now: float) -> list[Verdict]:
        """Return the judgements on `stream`, one for each of its media paths."""
        judged = (peer.judge(stream, now) for peer in self.all())
        return [verdict for verdict in judged if verdict is not None]

    def restart(self, peer_id: str) -> str:
        """Replace `peer_id` by a new peer; returns its id. Has no effect while it is being replaced already.

        Raises:
            UnknownPeer: there is no such peer, or it has no stream to carry; then
                it ends.
        """
        peer = self.find(peer_id)
        if not tuple(self._streams):
            self.end_all("there is no stream to carry")
            raise UnknownPeer("the peer connection has no stream to carry")
        if peer is self._present:
            if self._replaced is not None:
                self._replaced.end_connection("it was replaced")
            self._replaced = peer
            self._present = self._make(peer_id, self)
            for stream in self._streams:
                self._present.attach(stream)
            self.input.follow()
        assert self._present is not None, "there is a present one while there is any"
        return self._present.peer_id

    def tick(self, now: float, late: float) -> None:
        """Check all deadlines at the time `now`; `late` seconds before it do not count."""
        for peer in self.all():
            peer.tick(now, late)
        present, replaced = self._present, self._replaced
        if present is None or replaced is None or present.viewer is None:
            return
        plays = all(present.judge(stream, now) is Verdict.FLOWING for stream in self._streams if stream.is_open)
        if plays or now - present.viewer.since >= REPLACE_TIMEOUT:
            replaced.end_connection("it was replaced")

    def end_all(self, reason: str) -> None:
        """End all peers."""
        for peer in reversed(self.all()):  # the present one last, so that its streams do not fall back to the other
            peer.end_connection(reason)

    async def closed(self) -> None:
        """Wait until all ended peers are closed, which takes a bounded time."""
        for peer in self._closing:
            await peer.closed()

    def peer_says(self, message: Downward) -> None:
        """`message` is for the application."""
        self._send(message)

    def peer_answered(self) -> None:
        """An answer was applied."""
        self.was_answered = True

    def peer_changed(self, peer: Peer) -> None:
        """Note that media can pass over more of `peer` than before."""
        self._on_change()

    def peer_declined(self, peer: Peer, stream: Stream) -> None:
        """End `stream`, which the application declines."""
        self.detach(stream)
        self._streams.end_stream(stream)

    def peer_muted(self, reason: str) -> None:
        """Note that a peer has lost its input channels."""
        self.input.lost(reason)

    def peer_ended(self, peer: Peer) -> None:
        """Fall back to the replaced peer, if there is one, when `peer` has ended."""
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
            return  # it ended with the peer connection that could not be a fallback
        if self._present is None:
            self._streams.end_stream(stream)
        elif stream not in self._present.stream_paths:
            try:
                self._present.attach(stream)
            except TooManySections:
                self._streams.end_stream(stream)
            except PeerClosed as closed:
                self._present.end_connection(str(closed))
