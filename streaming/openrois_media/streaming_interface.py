"""RoIS Streaming Interface: RoIS and signaling methods in, the media plane behind, status notifications out.

RoIS terms end here: the media plane has sessions, peer connections and tracks.
"""

import itertools
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

from openrois_signaling.messages import Answer, Bye, Candidate, Direction, Downward, MediaKind, Restart
from openrois_streaming import errors as media_errors
from openrois_streaming import state
from openrois_streaming.adaptation.viewer import Caps
from openrois_streaming.clock import MediaClock
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.network.turns import Ingress
from openrois_streaming.peer.input_channels import Channels, InputSink, MakeChannels
from openrois_streaming.peer.stream import StreamChange
from openrois_streaming.publish.rendition_feed import MediaPublisher
from openrois_streaming.session.session import StreamSession
from openrois_streaming.session.sessions import StreamSessions
from openrois_streaming.source.uplink_sink import UplinkSink
from pydantic import ValidationError

from openrois.contract import Client
from openrois.errors import BadParameter, OutOfResources, RoISError, Unsupported
from openrois.types.codes import Purpose, ReturnCode, StreamStatus
from openrois.types.references import new_id
from openrois.types.streams import (
    STREAM_METHODS,
    HolderNotification,
    ReportPlayoutParams,
    SetConsentParams,
    StreamParams,
    StreamStatusNotification,
)
from openrois.types.values import date_time
from openrois_media.channel_sinks import ChannelSinks, NoSpeech, OperatorInput, SpeechInput
from openrois_media.stream_requests import (
    ConnectFromGateway,
    EncodingParameters,
    RestartFromGateway,
    TransportParameters,
    read_parameter,
)
from openrois_media.visitors.figures import VisitorFigures
from openrois_media.visitors.registry import VisitorRegistry, VisitorUplink
from openrois_media.visitors.relay import Relays
from openrois_media.visitors.visitor import Visitor

__all__ = ["OwnChannels", "Published", "StreamingInterface"]

_CONNECT: Final = STREAM_METHODS["connect_stream"]

_STATUS: Final = {
    state.StreamStatus.NOT_CONNECTED: StreamStatus.STREAMING_NOT_CONNECTED,
    state.StreamStatus.NOT_RUNNING: StreamStatus.STREAMING_NOT_RUNNING,
    state.StreamStatus.RUNNING: StreamStatus.STREAMING_RUNNING,
    state.StreamStatus.SUSPENDED: StreamStatus.STREAMING_SUSPENDED,
}

_REFUSALS: Final[dict[type[media_errors.SessionError], type[RoISError]]] = {
    media_errors.UnknownStream: Unsupported,
    media_errors.UnknownPeer: Unsupported,
    media_errors.NoCommonCodec: Unsupported,
    media_errors.NoEncoder: OutOfResources,
    media_errors.TooManySections: OutOfResources,
    media_errors.TooManySessions: OutOfResources,
    media_errors.TooManyCandidates: OutOfResources,
}


@dataclass(frozen=True, slots=True)
class Published:
    """Media of a streaming component: its publisher if any, its kind, and the sink of what an application sends."""

    publisher: MediaPublisher | None
    kind: MediaKind
    inlet: UplinkSink | VisitorUplink | None = None
    codecs: Callable[[], tuple[str, ...] | None] = lambda: None
    """Returns the only media types available now; None: all that can be encoded here."""

    def choose(self, wanted: tuple[str, ...] | None) -> tuple[str, ...] | None:
        """Return the available ones of the media types that an application names; None: any.

        Raises:
            Unsupported: it can decode none of the available ones.
        """
        ours = self.codecs()
        if ours is None or wanted is None:
            return wanted if ours is None else ours
        theirs = {name.lower().removeprefix(f"{self.kind}/") for name in wanted}
        found = tuple(codec for codec in ours if codec.lower().removeprefix(f"{self.kind}/") in theirs)
        if not found:
            needed = ", ".join(ours)
            raise Unsupported(f"the pictures come encoded as {needed}, which the application does not decode")
        return found

    @property
    def directions(self) -> tuple[Direction, ...]:
        """Available directions of an application (W3C's terms); only sound goes both ways in one stream."""
        if self.publisher is None:
            return ("sendonly",)
        if self.inlet is None:
            return ("recvonly",)
        return ("recvonly", "sendonly", "sendrecv") if self.kind == "audio" else ("recvonly", "sendonly")


@dataclass(frozen=True, slots=True)
class OwnChannels:
    """Data channels of another kind than `Channels`, and the sink of their messages.

    `make_sink` gets a function that sends the application a message.
    """

    make: MakeChannels
    make_sink: Callable[[Callable[[str | bytes], None]], InputSink]


class StreamingInterface:
    """Streaming Interface of one engine; an `Extension`.

    Its `sessions` have to be entered while it is used.

    Args:
        engine_id: prefix of the ids that are made here.
        published: the streaming components, by component_ref.
        clock: the media clock.
        network: network settings of the streams.
        cap: returns a client's limits of each stream, whatever it asks for; None: as much as its path carries.
        operator: input of the operator; None: the body cannot be operated.
        speech: speech as sound, or what refuses it; None: it is refused.
        visitors: the applications that send; None: those of this engine alone.
    """

    takes_role: Final = True
    """Visitors are told apart here, and their consent is kept to."""

    def __init__(
        self,
        engine_id: str,
        published: Mapping[str, Published],
        clock: MediaClock,
        network: NetworkSettings | None = None,
        cap: Callable[[Client], Caps] | None = None,
        operator: OperatorInput | None = None,
        speech: SpeechInput | None = None,
        visitors: VisitorRegistry | None = None,
    ) -> None:
        self.visitors = visitors or VisitorRegistry(engine_id, clock)
        self._relays = Relays(clock)
        self.visitors.withdrawn.add(self._end_relays)
        self._cap = cap
        self._operator = operator
        self._speech = speech or NoSpeech()
        self.guarded = GuardFigures()
        """Counts of dropped datagrams of all sessions."""
        self._network = network or NetworkSettings()
        self._ingress = Ingress(self._network.admission)
        self._engine_id = engine_id
        self._published = published
        self._clock = clock
        self._names: dict[Client, str] = {}
        self._channels: dict[Client, OwnChannels] = {}
        self._senders: dict[str, str] = {}
        """Stream that an application sends into a component, by component_ref."""
        self._numbers = itertools.count(1)
        self.sessions = StreamSessions(self._make_session, self._network.sessions)

    def engines(self) -> frozenset[str]:
        """Return the id of the engine."""
        return frozenset({self._engine_id})

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        """Handle a call of an application; the reply always precedes the notifications that it causes.

        Each `Client` has a session of its own: an application that comes over a new connection of the parent starts
        anew, while its old streams play on until the grace of the old connection is over.
        """
        if method == _CONNECT and client not in self._names:
            # Noted even if connecting fails: each client that tries to connect is forgotten once.
            self._names[client] = f"{client.client_id[:8]}-{next(self._numbers)}"
        try:
            more = await self._handle(method, params, client)
        except ValidationError as error:
            raise BadParameter(f"{method}: {error}") from error
        except media_errors.StaleGeneration:
            # The candidate was overtaken by a later offer, which the application will get.
            more = {}
        except media_errors.SessionError as error:
            raise _REFUSALS.get(type(error), BadParameter)(str(error)) from error
        return {"return_code": ReturnCode.OK.value, **more}

    async def _handle(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        match method:
            case "rois.stream.connect_stream":
                return self._connect(ConnectFromGateway.model_validate(params), client)
            case "rois.stream.query_stream_status":
                session, stream_id = self._stream(params, client)
                return {"status": _STATUS[session.status(stream_id)].value}
            case "rois.stream.suspend_stream":
                session, stream_id = self._stream(params, client)
                session.suspend(stream_id)
            case "rois.stream.resume_stream":
                session, stream_id = self._stream(params, client)
                session.resume(stream_id)
            case "rois.stream.disconnect_stream":
                session, stream_id = self._stream(params, client)
                session.disconnect(stream_id)
            case "rois.stream.report_playout":
                report = ReportPlayoutParams.model_validate(params)
                session = self.sessions.with_stream(self._session_name(client), report.stream_id)
                session.report_playout(report.stream_id, report.milliseconds / 1000)
            case "rois.stream.set_consent":
                stated = SetConsentParams.model_validate(params)
                return {"visitor_ref": self.visitors.set_consent(client, stated.stream_id, frozenset(stated.consent))}
            case _:
                await self._signal(method, params, client)
        return {}

    async def _signal(self, method: str, params: Mapping[str, Any], client: Client) -> None:
        match method:
            case Answer.method:
                answer = Answer.model_validate(params)
                await self.sessions.with_peer(self._session_name(client), answer.peer_id).apply_answer(answer)
            case Candidate.method:
                candidate = Candidate.model_validate(params)
                await self.sessions.with_peer(self._session_name(client), candidate.peer_id).add_candidate(candidate)
            case Restart.method:
                restart = RestartFromGateway.model_validate(params)
                session = self.sessions.with_peer(self._session_name(client), restart.peer_id)
                if restart.ice_servers is not None:
                    session.ice_servers = restart.ice_servers
                session.restart(restart.peer_id)
            case Bye.method:
                bye = Bye.model_validate(params)
                self.sessions.with_peer(self._session_name(client), bye.peer_id).end_peer(bye.peer_id, bye.reason)
            case _:
                raise Unsupported(f"there is no method {method}")

    def _stream(self, params: Mapping[str, Any], client: Client) -> tuple[StreamSession, str]:
        stream_id = StreamParams.model_validate(params).stream_id
        return self.sessions.with_stream(self._session_name(client), stream_id), stream_id

    def _connect(self, params: ConnectFromGateway, client: Client) -> dict[str, Any]:
        published = self._published.get(params.component_ref)
        if published is None:
            raise Unsupported(f"{params.component_ref} has no streams: use a streaming component")
        encoding = read_parameter(params.parameters, "encoding_parameters", EncodingParameters)
        transport = read_parameter(params.parameters, "transport_parameters", TransportParameters)
        if transport.visitor_ref:
            return self._relay(params, published, encoding, transport, client)
        direction = next((each for each in published.directions if each == transport.direction), None)
        if direction is None:
            possible = ", ".join(published.directions)
            raise Unsupported(
                f"{params.component_ref} has no streams of direction {transport.direction!r}: use {possible}"
            )
        sink = None
        if direction != "recvonly" and published.inlet is not None:
            sink = self.visitors.sink(client, published.inlet, published.kind)
            if params.component_ref in self._senders:
                raise OutOfResources(
                    f"another application sends to {params.component_ref} already: wait until its stream ends"
                )
        codecs = encoding.codecs if direction == "sendonly" else published.choose(encoding.codecs)
        session = self.sessions.open(self._session_name(client), may_bind=params.may_bind)
        session.ice_servers = params.ice_servers
        stream_id = new_id(self._engine_id)
        session.connect(
            stream_id,
            params.component_ref,
            None if direction == "sendonly" else published.publisher,
            published.kind,
            codecs,
            direction=direction,
            inlet=sink,
            caps=encoding.caps() if self._cap is None else encoding.caps().within(self._cap(client)),
            stereo=encoding.channels > 1,
        )
        has_input = self._operator is not None or client in self._channels
        if transport.speech or (transport.input and has_input):
            session.input.open()
        if sink is not None:
            if not isinstance(published.inlet, VisitorUplink):
                self._senders[params.component_ref] = stream_id
            self.visitors.add_stream(
                client, stream_id, sink, None if transport.consent is None else frozenset(transport.consent)
            )
        return {"stream_id": stream_id}

    def _relay(
        self,
        params: ConnectFromGateway,
        published: Published,
        encoding: EncodingParameters,
        transport: TransportParameters,
        client: Client,
    ) -> dict[str, Any]:
        """Connect a stream of what a visitor sends."""
        if params.role != "listener":
            raise Unsupported("only the role listener allows receiving what visitors send: use a token that has it")
        if transport.direction != "recvonly":
            raise Unsupported("what visitors send is received: use the direction recvonly")
        if not isinstance(published.inlet, VisitorUplink):
            raise Unsupported(f"{params.component_ref} takes nothing of visitors")
        visitor, purposes = self.visitors.find(transport.visitor_ref), frozenset(transport.purposes)
        publisher = self._relays.publisher(visitor, published.kind, purposes)
        session = self.sessions.open(self._session_name(client), may_bind=params.may_bind)
        session.ice_servers = params.ice_servers
        stream_id = new_id(self._engine_id)
        caps = encoding.caps() if self._cap is None else encoding.caps().within(self._cap(client))
        session.connect(stream_id, params.component_ref, publisher, published.kind, encoding.codecs, caps=caps)
        self._relays.add_stream(client, stream_id, visitor, purposes, publisher)
        return {"stream_id": stream_id}

    def _end_relays(self, visitor: Visitor, withdrawn: frozenset[Purpose]) -> None:
        for client, stream_id in self._relays.lost_with(visitor, withdrawn):
            # One that has ended meanwhile is not known any more.
            with suppress(media_errors.UnknownStream):
                self.sessions.with_stream(self._session_name(client), stream_id).disconnect(stream_id)

    def expect(self, client: Client, channels: OwnChannels) -> None:
        """Set the data channels of an application that is about to connect."""
        self._channels[client] = channels

    def request_key_frame(self, client: Client, stream_id: str) -> None:
        """Send an application a key frame.

        Raises:
            UnknownStream: the application has no such stream.
        """
        self.sessions.with_stream(self._session_name(client), stream_id).request_key_frame(stream_id)

    def _session_name(self, client: Client) -> str:
        """Return the name of a client's session; empty for a client that never tried to connect."""
        return self._names.get(client, "")

    def _make_session(self, session_name: str) -> StreamSession:
        client = next(client for client, name in self._names.items() if name == session_name)

        def send(message: Downward) -> None:
            client.notify(message.method, message.wire())

        def changed(change: StreamChange) -> None:
            if change.ended:
                if self._senders.get(change.component_ref) == change.stream_id:
                    del self._senders[change.component_ref]
                self._relays.end_stream(change.stream_id)
                self.visitors.end_stream(client, change.stream_id)
            self._announce(client, change)

        def reply(message: str | bytes) -> None:
            session.input.send_message(message)

        def answer(message: str) -> None:
            session.input.send_message(message, "speech")

        own = self._channels.get(client)
        operator = self._operator
        sink = ChannelSinks(
            None if operator is None else operator.input_sink(client, reply, lambda: session.round_trip_time),
            self._speech.speech_sink(client, answer),
        )
        session = StreamSession(
            mint=lambda: new_id(self._engine_id),
            send=send,
            on_change=changed,
            clock=self._clock,
            network=self._network,
            guarded=self.guarded,
            ingress=self._ingress,
            name=f"session {session_name}",
            sink=sink if own is None else own.make_sink(reply),
            channels=Channels if own is None else own.make,
        )
        return session

    @staticmethod
    def _announce(client: Client, change: StreamChange) -> None:
        statuses = [_STATUS[change.status]]
        if change.resumed:
            # RESUMED is an event only: what it announces is the status RUNNING.
            statuses.insert(0, StreamStatus.STREAMING_RESUMED)
        for status in statuses:
            notice = StreamStatusNotification(
                stream_id=change.stream_id,
                component_ref=change.component_ref,
                status=status,
                timestamp=date_time(change.at),
            )
            client.notify(notice.method, notice.model_dump(mode="json"))

    async def set_holder(self, notification: HolderNotification, client: Client) -> None:
        """Give or take operation by hand, or speech as sound, with the component."""
        for each in (self._operator, self._speech):
            if each is not None:
                each.apply_holder(notification, client)

    def visitor_figures(self) -> VisitorFigures:
        """Return the counts of visitors, and of what listeners receive of them."""
        return VisitorFigures(len(self.visitors.present), self.visitors.refused, len(self._relays))

    async def forget_client(self, client: Client) -> None:
        """End the streams of an application that is gone, its operation by hand and its speech."""
        for each in (self._operator, self._speech):
            if each is not None:
                each.forget_client(client)
        self._channels.pop(client, None)
        self.visitors.forget_client(client)
        session_name = self._names.pop(client, None)
        if session_name is not None:
            await self.sessions.close(session_name, "the application is gone")
