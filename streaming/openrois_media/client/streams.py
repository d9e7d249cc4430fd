"""All streams of one application, both ways: streaming verbs, signaling, peer connections, recovery."""

import asyncio
import json
import logging
from collections.abc import Sequence
from types import TracebackType
from typing import Any, Final, Self

from openrois_signaling.messages import Bye, Candidate, Offer
from openrois_streaming.clock import MediaClock
from openrois_streaming.codecs import H264, OPUS, VP8
from openrois_streaming.errors import SessionError
from pydantic import ValidationError

from openrois.aio.tasks import TaskScope
from openrois.client import (
    Client,
    Connected,
    ConnectionLost,
    ConnectionState,
    Disconnected,
    Fault,
    Notice,
    Notification,
    OutOfResources,
    ProfileChanged,
    RoISError,
    RpcError,
)
from openrois.types.codes import StreamStatus
from openrois.types.messages import Parameter
from openrois.types.streams import StreamStatusNotification
from openrois_media.client.ice_servers import IceServers
from openrois_media.client.negotiation import (
    AddCandidate,
    Apply,
    Close,
    Effect,
    Negotiation,
    Open,
    SendAnswer,
    SendCandidate,
)
from openrois_media.client.path_watch import FIRST_FRAME_WITHIN, Flow, Verdict
from openrois_media.client.peer import MediaPeer
from openrois_media.client.speeches import Speeches
from openrois_media.client.stream import ClientStream, ReceivedStream
from openrois_media.client.stream_state import Desire, Problem, Verb

__all__ = ["Streams"]

CODECS: Final = {"video": (H264, VP8), "audio": (OPUS,)}
"""Media types that are received and sent, best first."""

_OFFER_WITHIN: Final = 20.0
"""Seconds after which a connected stream without an offer is given up; the engine should do so after 15 s."""

_TICK: Final = 1.0
_QUICK_TICK: Final = 0.1
"""Seconds between two looks at the counts, usually and while a next section is awaited."""

_LEAVE_TIMEOUT: Final = 2.0
"""Seconds that the engine has to disconnect streams, when they are left."""

_MESSAGES: Final = 1024

_log = logging.getLogger(__name__)


class Streams:
    """Streams of one client. All streams of one engine share a peer connection.

    A new one (after a restart, or a new session) is opened beside the old one, each stream moves over when its first
    frame is there, and the old one is closed when it is empty.

    Args:
        client: the connection to the gateway; it must be open.
        clock: the clock of capture times.
    """

    def __init__(self, client: Client, clock: MediaClock) -> None:
        self._client = client
        self._clock = clock
        self.speeches = Speeches()
        """What is spoken by sound, over all peer connections."""
        self._negotiation = Negotiation()
        self._peers: dict[str, MediaPeer] = {}
        self._ice_servers = IceServers(client, clock)
        self._running: dict[ClientStream, asyncio.Task[None]] = {}
        self._closing: set[asyncio.Task[None]] = set()
        self._tasks = TaskScope()
        self._soon = asyncio.Event()

    async def __aenter__(self) -> Self:
        notifications = self._client.notifications(
            Offer.method, Candidate.method, Bye.method, StreamStatusNotification.method, buffer=_MESSAGES
        )
        notices = self._client.notices(Connected, Disconnected, Fault, ProfileChanged)
        await self._tasks.__aenter__()
        self._tasks.start(self._listen(notifications))
        self._tasks.start(self._follow(notices))
        self._tasks.start(self._judge_regularly())
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            await self._leave(*self._streams)
        finally:
            self._negotiation.abandon()
            for stream in self._streams:
                stream.place.drop()
            for peer in tuple(self._peers.values()):
                self._close_peer(peer)
            if self._closing:
                await asyncio.wait(self._closing)
            await self._tasks.__aexit__(kind, error, trace)

    def add(self, stream: ClientStream) -> None:
        """Run a stream, until `remove`."""
        self._running[stream] = self._tasks.start(stream.run())

    async def remove(self, stream: ClientStream) -> None:
        """Disconnect a stream for good."""
        await self._leave(stream)
        stream.place.drop()
        self._running.pop(stream).cancel()
        if isinstance(stream, ReceivedStream):
            stream.end_frames()
        self._close_empty_peers()

    @property
    def _streams(self) -> tuple[ClientStream, ...]:
        return tuple(self._running)

    # What each stream needs of all.

    def ready(self) -> bool:
        """Tell whether the gateway can be asked now."""
        return self._client.state is ConnectionState.CONNECTED

    async def connect(self, stream: ClientStream) -> str:
        """Connect a stream; returns its id."""
        await self._ice_servers.refresh()
        transport = stream.transport
        parameters = (
            _json_parameter("encoding_parameters", {"codecs": CODECS[stream.kind]}),
            _json_parameter("transport_parameters", {"direction": stream.direction, **transport}),
        )
        stream_id = await self._client.connect_stream(stream.component_ref, parameters)
        try:
            while stream.transport is not transport:
                # Consent was stated anew while the engine was asked with what was stated before.
                transport = stream.transport
                await self._client.call("rois.stream.set_consent", stream_id=stream_id, **transport)
        except BaseException:
            self._tasks.start(self._tell("rois.stream.disconnect_stream", {"stream_id": stream_id}))
            raise
        stream.known_transport = transport
        return stream_id

    async def perform(self, verb: Verb, stream_id: str) -> None:
        """Carry out a verb on a connected stream."""
        await self._client.call(f"rois.stream.{verb.value}", stream_id=stream_id)

    def relocate(self, stream: ClientStream) -> None:
        """Attach a stream to the newest peer that carries it, and close unused peers."""
        carriers = [(peer, peer.section(stream.state.stream_id)) for peer in self._peers.values()]
        for peer, section in reversed(carriers):
            if section is not None and section.kind == stream.kind:
                stream.place.attach(peer, section)
                break
        stream.news.notify()
        self._close_empty_peers()
        self._soon.set()

    # What the gateway says.

    async def _listen(self, notifications: Any) -> None:
        async for told in notifications:
            try:
                self._handle(told)
            except ValidationError as error:
                _log.warning("%s of the gateway cannot be read: %s", told.method, error)

    def _handle(self, told: Notification) -> None:
        match told.method:
            case Offer.method:
                self._run(self._negotiation.offer(Offer.model_validate(told.params)))
            case Candidate.method:
                self._run(self._negotiation.candidate(Candidate.model_validate(told.params)))
            case Bye.method:
                bye = Bye.model_validate(told.params)
                self._run(self._negotiation.end_peer(bye.peer_id, bye.reason))
            case StreamStatusNotification.method:
                report = StreamStatusNotification.model_validate(told.params)
                for stream in self._streams:
                    if stream.state.stream_id == report.stream_id:
                        stream.reported(report.status)
                self._close_empty_peers()

    async def _follow(self, notices: Any) -> None:
        try:
            async for notice in notices:
                self._notice(notice)
        except ConnectionLost as error:
            _log.info("the streams end with their client: %s", error)
        for stream in self._streams:
            stream.lost(None)
            if isinstance(stream, ReceivedStream):
                stream.end_frames()

    def _notice(self, notice: Notice) -> None:
        match notice:
            case Connected():
                for stream in self._streams:
                    stream.retry_now()
            case Disconnected():
                # Media may go on: the engine waits a while for its application to come back.
                self._negotiation.abandon()
                self._ice_servers.expire()
                for peer in self._peers.values():
                    peer.leaving = True
                for stream in self._streams:
                    stream.lost(None)
            case Fault(error_id=error_id):
                self._tasks.start(_explain(self._client, error_id, self._streams))
            case ProfileChanged():
                # The engine may be back, and with it what could not be connected.
                for stream in self._streams:
                    if stream.state.stream_id is None:
                        stream.retry_now()

    # Peer connections.

    def _run(self, effects: Sequence[Effect]) -> None:
        for effect in effects:
            match effect:
                case Open():
                    self._open_peer(effect)
                case Apply():
                    self._tasks.start(self._apply(effect.offer))
                case SendAnswer():
                    self._tasks.start(self._tell(effect.answer.method, effect.answer.wire()))
                case SendCandidate():
                    self._tasks.start(self._tell(effect.candidate.method, effect.candidate.wire()))
                case AddCandidate():
                    peer = self._peers.get(effect.peer_id)
                    if peer is not None:
                        self._tasks.start(peer.add_candidate(effect.candidate))
                case Close():
                    self._peer_ended(effect.peer_id)

    def _open_peer(self, effect: Open) -> None:
        peer_id = effect.peer_id
        self._peers[peer_id] = MediaPeer(
            peer_id,
            self._clock,
            self._ice_servers.current,
            lambda candidate: self._run(self._negotiation.gathered(peer_id, candidate)),
            self._state_changed,
            self.speeches.handle,
        )
        replaced = self._peers.get(effect.replaces or "")
        if replaced is not None:
            replaced.leaving = True

    def _state_changed(self) -> None:
        for stream in self._streams:
            stream.news.notify()
        self.speeches.follow()
        self._soon.set()

    async def _apply(self, offer: Offer) -> None:
        peer = self._peers.get(offer.peer_id)
        if peer is None:
            return
        try:
            sdp = await peer.apply(offer)
        except SessionError as error:
            if not peer.closed:
                # Half an answer cannot be taken back: the engine ends a peer that is not answered.
                _log.warning("an offer cannot be answered: %s", error)
                self._run(self._negotiation.end_peer(offer.peer_id, str(error)))
            return
        self._run(self._negotiation.answered(offer.peer_id, offer.generation, sdp, peer.connection.mid))
        for stream in self._streams:
            self.relocate(stream)

    def _peer_ended(self, peer_id: str) -> None:
        """Close a peer that has ended; streams that it alone carried are lost."""
        peer = self._peers.get(peer_id)
        if peer is None:
            return
        carried = peer.stream_ids
        self._close_peer(peer)
        for stream in self._streams:
            stream_id = stream.state.stream_id
            elsewhere = any(each.section(stream_id) for each in self._peers.values() if not each.leaving)
            if stream_id in carried and not elsewhere:
                stream.lost(StreamStatus.STREAMING_NOT_CONNECTED)

    def _close_peer(self, peer: MediaPeer) -> None:
        self._peers.pop(peer.peer_id, None)
        for stream in self._streams:
            stream.place.detach(peer)
        peer.closed = True
        self.speeches.follow()
        closing = self._tasks.start(peer.close())
        self._closing.add(closing)
        closing.add_done_callback(self._closing.discard)

    def _close_empty_peers(self) -> None:
        used = {each.peer for stream in self._streams for each in stream.place.attachments()}
        for peer in tuple(self._peers.values()):
            if peer.leaving and peer not in used:
                self._negotiation.end_peer(peer.peer_id, "replaced")
                self._close_peer(peer)

    # The clock.

    async def _judge_regularly(self) -> None:
        while True:
            waits = any(stream.place.next is not None for stream in self._streams)
            try:
                async with asyncio.timeout(_QUICK_TICK if waits else _TICK):
                    await self._soon.wait()
            except TimeoutError:
                pass
            self._soon.clear()
            self._judge(self._clock.now())

    def _judge(self, now: float) -> None:
        for stream in self._streams:
            stream.sample()
            self._miss_offer(stream, now)
            if isinstance(stream, ReceivedStream) and (delay := stream.playout_due()) is not None:
                report = {"stream_id": stream.state.stream_id, "milliseconds": min(round(delay * 1000), 60_000)}
                self._tasks.start(self._tell("rois.stream.report_playout", report))
        for peer in tuple(self._peers.values()):
            self._judge_peer(peer, now)
        self._close_empty_peers()

    def _miss_offer(self, stream: ClientStream, now: float) -> None:
        """Note a missing offer as a problem, and disconnect the stream when the engine does not."""
        state = stream.state
        if state.stream_id is None or state.desire is not Desire.RUNNING or stream.place.located:
            return
        waited = now - state.connected_at
        if waited >= FIRST_FRAME_WITHIN and state.problem is None:
            stream.fail(Problem("the engine makes no offer"))
        if waited >= _OFFER_WITHIN:
            self._tasks.start(self._tell("rois.stream.disconnect_stream", {"stream_id": state.stream_id}))
            stream.lost(StreamStatus.STREAMING_NOT_CONNECTED)

    def _judge_peer(self, peer: MediaPeer, now: float) -> None:
        state = peer.connection.state
        if peer.leaving:
            if state in ("failed", "closed"):
                self._close_peer(peer)
            return
        flows, waiting = [], []
        for stream in self._streams:
            newest = stream.place.newest
            if stream.place.located and newest is not None and newest.peer is peer:
                flows.append(Flow(stream.state.stream_id or "", stream.expects_media, newest.frames))
                waiting += [stream] if stream.expects_media else []
        if peer.watch.observe(now, state, flows) is Verdict.RESTART:
            for stream in waiting:
                stream.fail(Problem(f"no media arrives; the peer connection is {state}"))
            self._tasks.start(self._restart(peer.peer_id))

    async def _restart(self, peer_id: str) -> None:
        """Ask the engine for a new peer connection in place of one that has failed."""
        try:
            await self._ice_servers.refresh()
            await self._client.call("signaling.restart", peer_id=peer_id)
        except (OutOfResources, ConnectionLost, TimeoutError) as error:
            _log.info("a new peer connection is asked for later: %s", error)
        except (RoISError, RpcError) as error:
            # The engine does not know the peer any more: only a new connection of its streams can help.
            self._run(self._negotiation.end_peer(peer_id, str(error)))
            self._peer_ended(peer_id)

    async def _tell(self, method: str, params: dict[str, Any]) -> None:
        """Call a method whose failure leads to what is noticed anyway."""
        try:
            await self._client.call(method, **params)
        except (RoISError, RpcError, ConnectionLost, TimeoutError) as error:
            _log.debug("%s: %s", method, error)

    async def _leave(self, *streams: ClientStream) -> None:
        for stream in streams:
            stream.want(Desire.DISCONNECTED)
        try:
            async with asyncio.timeout(_LEAVE_TIMEOUT):
                for stream in streams:
                    await stream.settled()
        except TimeoutError:
            _log.info("the engine does not say that streams are disconnected")


def _json_parameter(name: str, value: dict[str, Any]) -> Parameter:
    return Parameter(name=name, data_type_ref="string", value=json.dumps(value))


async def _explain(client: Client, error_id: str, streams: Sequence[ClientStream]) -> None:
    """Let the streams of a component that reports a fault say what it is."""
    try:
        details = await client.get_error_detail(error_id)
    except (RoISError, RpcError, ConnectionLost, TimeoutError):
        return
    told = {each.name: each.value for each in details}
    for stream in streams:
        if stream.component_ref == told.get("component_ref"):
            stream.note_fault(told.get("description", ""))
