"""Stream session of one application: its streams, over one peer connection."""

import logging
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Final, Self

from openrois_signaling.messages import Answer, Candidate, Direction, Downward, IceServer, MediaKind

from openrois_streaming.adaptation.viewer import Caps
from openrois_streaming.clock import MediaClock
from openrois_streaming.errors import NoEncoder
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.network.turns import Ingress
from openrois_streaming.peer.input_channels import Channels, InputSink, MakeChannels
from openrois_streaming.peer.peer import Peer, PeerOwner
from openrois_streaming.peer.peers import Peers
from openrois_streaming.peer.stream import Stream, StreamChange, StreamTable, choose_codecs
from openrois_streaming.publish.rendition_feed import MediaPublisher
from openrois_streaming.source.uplink_sink import UplinkSelector, UplinkSink
from openrois_streaming.state import Party, StreamStatus
from openrois_streaming.stats import Counters, StreamStats
from openrois_streaming.tasks import OwnedTasks, Task

TICK = 0.125
"""Seconds between two checks of deadlines, signs of life and progress; a power of two, whose multiples are exact."""

LATE = 1.0
"""Seconds that a check may be late before the delay counts as this process's own: it was stopped, or the machine
slept."""

CODECS_APART = 20.0
"""Seconds between two peer connections for another codec; an unanswered one ends after 15."""

IDLE = 30.0
"""Seconds for which a peer connection without streams is kept: the next stream can reuse its section."""

DIRECTIONS: Final[tuple[Direction, ...]] = ("recvonly", "sendonly", "sendrecv")
"""Directions that a stream can have."""

_log = logging.getLogger(__name__)


class StreamSession:
    """Streams of one application, as m-sections of one peer connection (of two while one replaces the other).

    To be used inside `async with`; leaving it ends everything. `send` gets offers, candidates and byes, `on_change`
    every change of a stream's status. Both are called in the event loop and must neither block nor raise. They are not
    called from within the methods that answer a request (so that the reply can go first), except that `apply_answer`
    and `restart` may send a bye for a peer connection that they end.

    Args:
        mint: makes a new peer id.
        ice_servers: for the peer connections that are made from now on; may be set at any time.
        network: network settings of the peer connections.
        guarded: counts dropped datagrams; sessions may share it.
        ingress: limits on received datagrams of all sessions; one of its own if none is given.
        clock: times all deadlines.
        name: its name in logs and tasks.
        sink: gets operator input, once `input` is opened; None: input is ignored.
        channels: makes the data channels of input.
    """

    def __init__(
        self,
        *,
        mint: Callable[[], str],
        send: Callable[[Downward], None],
        on_change: Callable[[StreamChange], None],
        clock: MediaClock,
        ice_servers: Sequence[IceServer] = (),
        network: NetworkSettings | None = None,
        guarded: GuardFigures | None = None,
        ingress: Ingress | None = None,
        name: str = "session",
        sink: InputSink | None = None,
        channels: MakeChannels = Channels,
    ) -> None:

        def failed(error: BaseException) -> None:
            _log.error("%s: an internal error ends it", name, exc_info=error)
            self._peers.end_all("an internal error of the engine")
            self._streams.notify_changes()

        self.ice_servers = tuple(ice_servers)
        self.guarded = guarded or GuardFigures()
        """Counts of dropped datagrams."""
        network = network or NetworkSettings()
        admitting = ingress or Ingress(network.admission)
        self._clock = clock
        self._name = name
        self._tasks = OwnedTasks(name, failed)
        self._streams = StreamTable(on_change, clock)
        self.report_playout = self._streams.report_playout
        """Notes the playout delay of a stream, see `StreamTable.report_playout`."""

        def make_peer(replaces: str | None, owner: PeerOwner) -> Peer:
            return Peer(
                mint(),
                replaces=replaces,
                ice_servers=self.ice_servers,
                network=network,
                guarded=self.guarded,
                ingress=admitting,
                clock=clock,
                tasks=self._tasks,
                owner=owner,
                channels=channels,
            )

        self._peers = Peers(self._streams, make_peer, send, self._update_soon, sink)
        self.input = self._peers.input
        """Operator input of the application; it is `open`ed when the application wants to send it."""
        self._supervisor: Task[None] | None = None
        self._held: dict[str, frozenset[Direction]] = {}
        self._closed = False
        self._made_at = self._played_at = clock.now()
        self._codecs_changed_at = float("-inf")

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close("the session is over")

    @property
    def stream_ids(self) -> tuple[str, ...]:
        """Ids of the streams that have not ended."""
        return tuple(stream.stream_id for stream in self._streams)

    @property
    def peer_ids(self) -> tuple[str, ...]:
        """Ids of the peer connections that have not ended, the present one first."""
        return tuple(peer.peer_id for peer in self._peers.all())

    @property
    def is_over(self) -> bool:
        """Whether no peer connection is left."""
        return not self._peers.all()

    @property
    def round_trip_time(self) -> float | None:
        """Round-trip time to the viewer in seconds, smoothed; None before its first report."""
        return self._peers.round_trip_time

    def unanswered_for(self) -> float | None:
        """Return the seconds since the session was made; None once one of its peer connections was answered."""
        return None if self._peers.was_answered else self._clock.now() - self._made_at

    def connect(
        self,
        stream_id: str,
        component_ref: str,
        publisher: MediaPublisher | None,
        kind: MediaKind,
        codecs: Sequence[str] | None = None,
        *,
        direction: Direction = "recvonly",
        inlet: UplinkSink | None = None,
        caps: Caps | None = None,
        stereo: bool = False,
    ) -> None:
        """Add a stream; an offer follows.

        Args:
            stream_id: an id that is never used again.
            component_ref: the component of the stream.
            publisher: source of the frames that the application receives; None if it only sends.
            kind: "video" or "audio".
            codecs: codecs that the application can decode, and encode if it sends, as media types or their subtypes;
                None if it named none.
            direction: seen from the application (W3C's RTCRtpTransceiverDirection); `sendrecv` for audio only.
            inlet: sink of the application's media; None if it only receives.
            caps: limits of what it is sent; None for as much as its path carries.
            stereo: whether it is asked to send two channels of sound, if it sends any.

        Raises:
            NoCommonCodec: it can use none of the available codecs.
            NoEncoder: its codecs would need one more encoder than the limit.
            TooManySections: all sections of the peer connection are in use.
            ValueError: the session is closed, has the stream already, or the direction does not fit publisher and
                inlet.
        """
        if self._closed or stream_id in self._streams:
            raise ValueError("a stream is connected once, to an open session: use a new id")
        if (publisher is None) is not (direction == "sendonly") or (inlet is None) is not (direction == "recvonly"):
            raise ValueError(f"a {direction} stream has other ends: see publisher and inlet")
        if direction == "sendrecv" and kind != "audio":
            raise ValueError("sendrecv is for audio alone: connect two streams of video")
        selector = None if inlet is None else UplinkSelector(stream_id, inlet)
        known = chosen = choose_codecs(kind, codecs)
        if publisher is not None:
            names = ", ".join(chosen)
            chosen = tuple(codec for codec in chosen if publisher.has_room(codec))
            if not chosen:
                raise NoEncoder(
                    f"all encoders of the adapter are in use, and none of them encodes {names}:"
                    " disconnect another stream, or raise max_encoders of the adapter"
                )
            chosen = tuple(codec for codec in chosen if publisher.can_encode(codec)) or chosen
        stream = Stream(
            stream_id,
            component_ref,
            kind,
            publisher,
            chosen if codecs is None else chosen[:1],
            Counters(),
            direction,
            selector,
            caps or Caps(),
            stereo,
            () if codecs is None else known,
        )
        if direction in self._held.get(component_ref, ()):
            stream.suspend(Party.ENGINE)
        self._peers.attach(stream)
        self._streams.add(stream)
        self._played_at = self._clock.now()
        if self._supervisor is None or self._supervisor.done():
            self._supervisor = self._tasks.start(self._supervise(), "supervisor")

    def suspend(self, stream_id: str) -> None:
        """Suspend a stream for the application; repeating it has no effect. Raises UnknownStream."""
        self._streams[stream_id].suspend(Party.APPLICATION)
        self._update_soon()

    def resume(self, stream_id: str) -> None:
        """Resume a stream from a key frame on, without a negotiation; repeating it has no effect. Raises UnknownStream.

        While the engine holds its component the stream stays suspended, and goes on when that is released.
        """
        self._streams[stream_id].resume(Party.APPLICATION)
        self._update_soon()

    def hold(self, component_ref: str, *directions: Direction) -> None:
        """Suspend the present and later streams of a component for the engine.

        Only those of `directions`, if any are given.
        """
        held = self._held[component_ref] = frozenset(directions or DIRECTIONS)
        for stream in self._streams:
            if stream.component_ref == component_ref and stream.direction in held:
                stream.suspend(Party.ENGINE)
        self._update_soon()

    def release(self, component_ref: str) -> None:
        """Resume the streams that `hold` has suspended; those that the application has suspended stay so."""
        self._held.pop(component_ref, None)
        for stream in self._streams:
            if stream.component_ref == component_ref:
                stream.resume(Party.ENGINE)
        self._update_soon()

    def disconnect(self, stream_id: str) -> None:
        """Disconnect a stream; an offer follows that makes its section idle. Raises UnknownStream."""
        stream = self._streams[stream_id]
        self._peers.detach(stream)
        self._streams.end_stream(stream)
        self._update_soon()

    def status(self, stream_id: str) -> StreamStatus:
        """Return the present status of a stream. Raises UnknownStream."""
        return self._streams[stream_id].status

    def request_key_frame(self, stream_id: str) -> None:
        """Request a key frame of a stream, within the budget of its encoder. Raises UnknownStream."""
        self._peers.path_of(self._streams[stream_id]).key_frame_wanted()

    async def stats(self, stream_id: str) -> StreamStats:
        """Return the present figures of a stream. Raises UnknownStream."""
        return await self._peers.path_of(self._streams[stream_id]).stats()

    async def apply_answer(self, answer: Answer) -> None:
        """Hand an answer to its peer connection; raises UnknownPeer and what `Peer.apply_answer` raises."""
        await self._peers.find(answer.peer_id).apply_answer(answer)

    async def add_candidate(self, candidate: Candidate) -> None:
        """Hand a candidate to its peer connection; raises UnknownPeer and what `Peer.add_candidate` raises."""
        await self._peers.find(candidate.peer_id).add_candidate(candidate)

    def restart(self, peer_id: str) -> str:
        """Make a new peer connection that replaces `peer_id`; an offer follows. Returns its id.

        The old one goes on until the new one plays. Streams keep their ids and stay suspended if they are. A repeated
        call while it is being replaced has no effect. Raises UnknownPeer.
        """
        return self._peers.restart(peer_id)

    def end_peer(self, peer_id: str, reason: str) -> None:
        """End a peer connection that cannot be established. Raises UnknownPeer."""
        self._peers.find(peer_id).end_connection(reason)

    async def close(self, reason: str) -> None:
        """End all streams and peer connections and wait until they are closed, for a few seconds at most."""
        self._closed = True
        self._peers.end_all(reason)
        self._streams.notify_changes()
        await self._peers.closed()
        await self._tasks.aclose()

    async def _supervise(self) -> None:
        due = self._clock.now()
        while self._peers.all():
            now = self._clock.now()
            self._peers.tick(now, now - due if now - due > LATE else 0.0)
            if self.stream_ids:
                self._played_at = now
            elif now - self._played_at >= IDLE:
                self._peers.end_all("no stream is left to play")
            self._change_codecs()
            await self._update_streams()
            # All sessions check at the same moments: to wake the process takes longer than a check.
            due = (self._clock.now() // TICK + 1) * TICK
            await self._clock.sleep_until(due)

    def _change_codecs(self) -> None:
        """Replace the peer connection if its codec cannot be encoded and the viewer can decode another."""
        peers, now = self._peers.all(), self._clock.now()
        if len(peers) != 1 or now - self._codecs_changed_at < CODECS_APART:
            return
        played = {stream: self._peers.path_of(stream).section.codec for stream in self._streams if stream.alternatives}
        if True in {stream.change_codec(codec) for stream, codec in played.items() if codec is not None}:
            self._codecs_changed_at = now
            _log.warning("%s: an encoder fails repeatedly: another codec is offered", self._name)
            self._peers.restart(peers[0].peer_id)

    def _update_soon(self) -> None:
        """Apply the phases of the streams now; update them before the next tick, but not within the present call."""
        if not self._closed:
            self._peers.follow()
            self._tasks.start(self._update_streams(), "look")

    async def _update_streams(self) -> None:
        """Judge every stream by its measurements, and notify the changes."""
        now = self._clock.now()
        for stream in self._streams:
            stream.judge(self._peers.verdicts(stream, now))
        self._streams.notify_changes()
