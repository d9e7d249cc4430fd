"""The RoIS Streaming Interface of a game engine that does WebRTC itself, over players of the engine."""

from collections.abc import Callable, Mapping
from typing import Any, Final

from openrois_media.stream_requests import (
    ConnectFromGateway,
    EncodingParameters,
    RestartFromGateway,
    TransportParameters,
    read_parameter,
)
from openrois_signaling.messages import Answer, Bye, Candidate, Downward, MediaKind, Restart
from openrois_streaming import errors as media_errors
from openrois_streaming.clock import MediaClock
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.peer.sdp import read_candidate
from pydantic import ValidationError

from openrois.contract import Client
from openrois.errors import BadParameter, ComponentFailed, OutOfResources, RoISError, Unsupported
from openrois.types.codes import ReturnCode
from openrois.types.references import new_id
from openrois.types.streams import HolderNotification, StreamParams, StreamStatusNotification
from openrois.types.values import date_time
from openrois_avatar.facades.session import FacadeSession
from openrois_avatar.facades.session_streams import Change
from openrois_avatar.facades.streamer import Heard, NoRoom, NotOffered, Streamer

__all__ = ["FacadeStreams"]


_TICK: Final = 0.05
"""Seconds between two checks of the applications."""

_REFUSALS: Final[tuple[tuple[type[Exception], type[RoISError]], ...]] = (
    (media_errors.UnknownStream, Unsupported),
    (media_errors.UnknownPeer, Unsupported),
    (NotOffered, Unsupported),
    (NoRoom, OutOfResources),
    (media_errors.TooManySections, OutOfResources),
    (media_errors.TooManyCandidates, OutOfResources),
    (media_errors.SessionError, BadParameter),
    (ValidationError, BadParameter),
)


class FacadeStreams:
    """Connects applications to a game engine's own peer connections; an `Extension`. `run` has to run meanwhile.

    Args:
        engine_id: leads the ids of streams and peers.
        kinds: of the streaming components, by component_ref.
        streamer: returns the game engine, if one is ready for players.
        absent: returns why there is none.
        clock: the media clock.
        network: policy for the addresses of applications, and limits of their number.
    """

    def __init__(
        self,
        engine_id: str,
        kinds: Mapping[str, MediaKind],
        streamer: Callable[[], Streamer | None],
        absent: Callable[[], str],
        clock: MediaClock,
        network: NetworkSettings,
    ) -> None:
        self._engine_id = engine_id
        self._kinds = kinds
        self._streamer = streamer
        self._absent = absent
        self._clock = clock
        self._policy = network.policy
        self._places = network.sessions
        self._may_bind: dict[Client, bool] = {}
        self._sessions: dict[Client, FacadeSession] = {}

    def __len__(self) -> int:
        """Return the number of applications with streams or peer connections."""
        return sum(not session.is_over for session in self._sessions.values())

    def engines(self) -> frozenset[str]:
        """Return the id of the avatar's engine."""
        return frozenset({self._engine_id})

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        """Handle a request of an application; the reply always comes before the notifications that it causes."""
        try:
            more = self._handle(method, params, client)
        except media_errors.StaleGeneration:
            # A candidate that was overtaken by a later offer, which the application will get.
            more = {}
        except tuple(kind for kind, _ in _REFUSALS) as error:
            refusal = next(refusal for kind, refusal in _REFUSALS if isinstance(error, kind))
            raise refusal(str(error)) from error
        return {"return_code": ReturnCode.OK.value, **more}

    def _handle(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        match method:
            case "rois.stream.connect_stream":
                return self._connect(ConnectFromGateway.model_validate(params), client)
            case "rois.stream.query_stream_status":
                session, stream_id = self._stream(params, client)
                return {"status": session.status(stream_id).value}
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
                pass  # sound comes from the game engine itself: nothing here depends on its playout
            case _:
                self._signal(method, params, client)
        return {}

    def _signal(self, method: str, params: Mapping[str, Any], client: Client) -> None:
        session = self._sessions.get(client)
        if session is None:
            raise media_errors.UnknownPeer("the peer connection does not exist, or has ended")
        match method:
            case Answer.method:
                session.apply_answer(Answer.model_validate(params))
            case Candidate.method:
                session.add_candidate(Candidate.model_validate(params))
            case Restart.method:
                restart = RestartFromGateway.model_validate(params)
                if restart.ice_servers is not None:
                    session.ice_servers = restart.ice_servers
                session.restart(restart.peer_id)
            case Bye.method:
                bye = Bye.model_validate(params)
                session.end_peer(bye.peer_id, bye.reason)
            case _:
                raise Unsupported(f"there is no method {method}")

    def _stream(self, params: Mapping[str, Any], client: Client) -> tuple[FacadeSession, str]:
        stream_id = StreamParams.model_validate(params).stream_id
        session = self._sessions.get(client)
        if session is None:
            raise media_errors.UnknownStream("the stream does not exist, or has ended")
        return session, stream_id

    def _connect(self, params: ConnectFromGateway, client: Client) -> dict[str, Any]:
        kind = self._kinds.get(params.component_ref)
        if kind is None:
            raise Unsupported(f"{params.component_ref} has no streams")
        # Codecs are negotiated between the browser and the game engine.
        read_parameter(params.parameters, "encoding_parameters", EncodingParameters)
        direction = read_parameter(params.parameters, "transport_parameters", TransportParameters).direction
        if direction != "recvonly":
            raise Unsupported(f"{params.component_ref} has no streams of direction {direction!r}, only recvonly")
        if self._streamer() is None:
            raise ComponentFailed(self._absent())
        session = self._sessions.get(client) or self._open(client, params.may_bind)
        # Its role may have changed since its first stream.
        self._may_bind[client] = params.may_bind
        session.ice_servers = params.ice_servers
        stream_id = new_id(self._engine_id)
        session.connect(stream_id, params.component_ref, kind)
        return {"stream_id": stream_id}

    def _open(self, client: Client, may_bind: bool) -> FacadeSession:
        if not self._has_room(may_bind):
            self._sessions = {each: session for each, session in self._sessions.items() if not session.is_over}
            self._may_bind = {each: self._may_bind[each] for each in self._sessions}
        if not self._has_room(may_bind):
            self._displace(may_bind)

        def send(message: Downward) -> None:
            client.notify(message.method, message.wire())

        def changed(change: Change) -> None:
            notice = StreamStatusNotification(
                stream_id=change.stream_id,
                component_ref=change.component_ref,
                status=change.status,
                timestamp=date_time(self._clock.wall()),
            )
            client.notify(notice.method, notice.model_dump(mode="json"))

        session = self._sessions[client] = FacadeSession(
            lambda: new_id(self._engine_id), self._streamer, send, changed, self._clock.now, self._permits
        )
        return session

    def _displace(self, may_bind: bool) -> None:
        waits = ((each, session.unanswered_for()) for each, session in self._sessions.items())
        unanswered = {each: seconds for each, seconds in waits if seconds is not None}
        late = self._places.displaced(self._may_bind, unanswered, may_bind)
        if late is None:
            raise OutOfResources(
                f"{len(self._sessions)} of at most {self._places.applications} applications are served"
            )
        del self._may_bind[late]
        self._sessions.pop(late).close("its offer was not answered in time, and another application needs the place")

    def _has_room(self, may_bind: bool) -> bool:
        return self._places.has_room(self._may_bind.values(), may_bind)

    def _permits(self, candidate: str) -> bool:
        return read_candidate(candidate, "0", self._policy) is not None

    async def set_holder(self, notification: HolderNotification, client: Client) -> None:
        """Ignore the notification: nothing here depends on leases."""

    async def forget_client(self, client: Client) -> None:
        """End the streams of an application that has disconnected."""
        session = self._sessions.pop(client, None)
        self._may_bind.pop(client, None)
        if session is not None:
            session.close("the application is gone")

    def handle_engine_message(self, heard: Heard) -> None:
        """Handle a message of the game engine to a player."""
        for session in tuple(self._sessions.values()):
            session.handle_engine_message(heard)

    def engine_lost(self) -> None:
        """End all streams: the game engine is disconnected."""
        self._close("the game engine is gone")

    def _close(self, reason: str) -> None:
        for session in tuple(self._sessions.values()):
            session.close(reason)

    def check_deadlines(self) -> None:
        """Check deadlines of all applications, and send notifications of changes."""
        for session in tuple(self._sessions.values()):
            session.tick()

    async def run(self) -> None:
        """Check deadlines until cancelled; then end all streams."""
        try:
            while True:
                self.check_deadlines()
                await self._clock.sleep_until(self._clock.now() + _TICK)
        finally:
            self._close("the engine stops")
