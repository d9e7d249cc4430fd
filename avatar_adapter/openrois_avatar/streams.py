"""The streams of the avatar: RoIS and signaling methods in, the media plane behind, status notifications out.

RoIS words end here: below it is about sessions, peer connections and tracks.
"""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from openrois_signaling.messages import Answer, Bye, Candidate, Direction, Downward, MediaKind, Restart
from openrois_streaming import errors as media_errors
from openrois_streaming import state
from openrois_streaming.adaptation.caps import Caps
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
from openrois.types.codes import ReturnCode, StreamStatus
from openrois.types.references import new_id
from openrois.types.streams import (
    STREAM_METHODS,
    HolderNotification,
    ReportPlayoutParams,
    StreamParams,
    StreamStatusNotification,
)
from openrois.types.values import date_time
from openrois_avatar.stream_requests import (
    ConnectFromGateway,
    EncodingParameters,
    RestartFromGateway,
    TransportParameters,
    read_parameter,
)
from openrois_avatar.teleoperation.seat import Seat

__all__ = ["AvatarStreams", "OwnChannels", "Published"]

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
    """What a streaming component sends: its frames, and of which kind they are; and where it takes an application's."""

    publisher: MediaPublisher
    kind: MediaKind
    inlet: UplinkSink | None = None
    codecs: Callable[[], tuple[str, ...] | None] = lambda: None
    """The only media types that it can be had in now; None: all that can be encoded here."""

    def choose(self, wanted: tuple[str, ...] | None) -> tuple[str, ...] | None:
        """The media types that an application can be sent of those it wants; None: any.

        Raises:
            Unsupported: it can decode none that there is.
        """
        ours = self.codecs()
        if ours is None or wanted is None:
            return wanted if ours is None else ours
        theirs = {name.lower().removeprefix(f"{self.kind}/") for name in wanted}
        found = tuple(codec for codec in ours if codec.lower().removeprefix(f"{self.kind}/") in theirs)
        if not found:
            raise Unsupported(f"the pictures come encoded as {', '.join(ours)}, which the application does not decode")
        return found

    @property
    def directions(self) -> tuple[Direction, ...]:
        """What an application can do here, as W3C says it; in one stream only sound goes both ways."""
        if self.inlet is None:
            return ("recvonly",)
        return ("recvonly", "sendonly", "sendrecv") if self.kind == "audio" else ("recvonly", "sendonly")


@dataclass(frozen=True, slots=True)
class OwnChannels:
    """Data channels of another kind than the usual, and who hears what comes over them.

    `hands` is given what sends the application a message.
    """

    make: MakeChannels
    hands: Callable[[Callable[[str | bytes], None]], InputSink]


class AvatarStreams:
    """Connects applications to what the avatar shows and says; an `Extension`.

    Its `sessions` have to be entered for as long as it is used.

    Args:
        engine_id: leads the ids that are minted here.
        published: the streaming components, by component_ref.
        clock: the media clock.
        network: how the streams use the network.
        cap: what a client is sent at most of each stream, whatever it asks for; None: as much as its path carries.
        seat: who operates the avatar by hand; None: it cannot be operated.
    """

    def __init__(
        self,
        engine_id: str,
        published: Mapping[str, Published],
        clock: MediaClock,
        network: NetworkSettings | None = None,
        cap: Callable[[Client], Caps] | None = None,
        seat: Seat | None = None,
    ) -> None:
        self._cap = cap
        self._seat = seat
        self.guarded = GuardFigures()
        """What did not get in from the network, of all sessions together."""
        self._network = network or NetworkSettings()
        self._ingress = Ingress(self._network.admission)
        self._engine_id = engine_id
        self._published = published
        self._clock = clock
        self._names: dict[Client, str] = {}
        self._channels: dict[Client, OwnChannels] = {}
        self._senders: dict[str, str] = {}
        """The stream that an application sends into a component."""
        self._numbers = itertools.count(1)
        self.sessions = StreamSessions(self._make_session, self._network.places)

    def engines(self) -> frozenset[str]:
        """Return the id of the avatar's engine."""
        return frozenset({self._engine_id})

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        """Do what an application asks; the reply always comes before the notifications that it causes.

        Each `Client` has a session of its own: an application that comes over a new connection of the parent starts
        anew, while what it had plays on until the grace of the old connection is over.
        """
        if method == _CONNECT and client not in self._names:
            # Noted whatever comes of it: each that tries to connect is forgotten once.
            self._names[client] = f"{client.client_id[:8]}-{next(self._numbers)}"
        try:
            more = await self._handle(method, params, client)
        except ValidationError as error:
            raise BadParameter(f"{method}: {error}") from error
        except media_errors.StaleGeneration:
            # A candidate that was overtaken by a later offer; the application will see that one.
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
            case HolderNotification.method:
                if self._seat is not None:
                    self._seat.take_holder(HolderNotification.model_validate(params), client)
            case _:
                await self._signal(method, params, client)
        return {}

    async def _signal(self, method: str, params: Mapping[str, Any], client: Client) -> None:
        match method:
            case Answer.method:
                answer = Answer.model_validate(params)
                await self.sessions.with_peer(self._session_name(client), answer.peer_id).answer(answer)
            case Candidate.method:
                candidate = Candidate.model_validate(params)
                await self.sessions.with_peer(self._session_name(client), candidate.peer_id).candidate(candidate)
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
            raise Unsupported(f"{params.component_ref} has no streams")
        encoding = read_parameter(params.parameters, "encoding_parameters", EncodingParameters)
        transport = read_parameter(params.parameters, "transport_parameters", TransportParameters)
        direction = next((each for each in published.directions if each == transport.direction), None)
        if direction is None:
            possible = ", ".join(published.directions)
            raise Unsupported(f"{params.component_ref} has no streams of direction {transport.direction!r}: {possible}")
        if direction != "recvonly" and params.component_ref in self._senders:
            raise OutOfResources(
                f"another application sends to {params.component_ref} already, and only one can at a time"
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
            inlet=None if direction == "recvonly" else published.inlet,
            caps=encoding.caps() if self._cap is None else encoding.caps().within(self._cap(client)),
            stereo=encoding.channels > 1,
        )
        if transport.input:
            session.input.open()
        if direction != "recvonly":
            self._senders[params.component_ref] = stream_id
        return {"stream_id": stream_id}

    def expect(self, client: Client, channels: OwnChannels) -> None:
        """Let an application that is about to connect have data channels of its own kind."""
        self._channels[client] = channels

    def request_key_frame(self, client: Client, stream_id: str) -> None:
        """Send an application a picture that stands for itself.

        Raises:
            UnknownStream: it has no such stream.
        """
        self.sessions.with_stream(self._session_name(client), stream_id).request_key_frame(stream_id)

    def _session_name(self, client: Client) -> str:
        """The name of a client's session; empty for one that never tried to connect."""
        return self._names.get(client, "")

    def _make_session(self, session_name: str) -> StreamSession:
        client = next(client for client, name in self._names.items() if name == session_name)

        def send(message: Downward) -> None:
            client.notify(message.method, message.wire())

        def changed(change: StreamChange) -> None:
            if change.ended and self._senders.get(change.component_ref) == change.stream_id:
                del self._senders[change.component_ref]
            self._announce(client, change)

        def tell(message: str | bytes) -> None:
            session.input.tell(message)

        own = self._channels.get(client)
        sink = None if self._seat is None else self._seat.hands(client, tell, lambda: session.round_trip_time)
        session = StreamSession(
            mint=lambda: new_id(self._engine_id),
            send=send,
            on_change=changed,
            clock=self._clock,
            network=self._network,
            guarded=self.guarded,
            ingress=self._ingress,
            name=f"session {session_name}",
            sink=sink if own is None else own.hands(tell),
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

    async def forget(self, client: Client) -> None:
        """End the streams of an application that is gone, and what it holds."""
        if self._seat is not None:
            self._seat.forget(client)
        self._channels.pop(client, None)
        session_name = self._names.pop(client, None)
        if session_name is not None:
            await self.sessions.close(session_name, "the application is gone")
