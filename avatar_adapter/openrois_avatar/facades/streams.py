"""The streams of a game engine that does WebRTC itself: RoIS and signaling methods in, players of the engine behind."""

import logging
from collections.abc import Callable, Mapping
from typing import Any, Final

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
from openrois_avatar.facades.streamer import Heard, NoRoom, NotOffered, Streamer
from openrois_avatar.facades.viewed import Change
from openrois_avatar.facades.viewing import Viewing
from openrois_avatar.stream_requests import (
    ConnectFromGateway,
    EncodingParameters,
    RestartFromGateway,
    TransportParameters,
    read_parameter,
)

__all__ = ["FacadeStreams"]

_log = logging.getLogger(__name__)

_TICK: Final = 0.05
"""Seconds between two looks at the applications."""

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
        engine_id: leads the ids that are minted here.
        kinds: what the streaming components stream, by component_ref.
        streamer: the game engine, if one is there that can be sent players.
        absent: says why there is none.
        clock: the media clock.
        network: which addresses of applications the game engine is told, and how many there may be.
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
        self._places = network.places
        self._may_bind: dict[Client, bool] = {}
        self._viewings: dict[Client, Viewing] = {}

    def __len__(self) -> int:
        """How many applications have something to see."""
        return sum(not viewing.is_over for viewing in self._viewings.values())

    def engines(self) -> frozenset[str]:
        """Return the id of the avatar's engine."""
        return frozenset({self._engine_id})

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        """Do what an application asks; the reply always comes before the notifications that it causes."""
        try:
            more = self._handle(method, params, client)
        except media_errors.StaleGeneration:
            # A candidate that was overtaken by a later offer; the application will see that one.
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
                viewing, stream_id = self._stream(params, client)
                return {"status": viewing.status(stream_id).value}
            case "rois.stream.suspend_stream":
                viewing, stream_id = self._stream(params, client)
                viewing.suspend(stream_id)
            case "rois.stream.resume_stream":
                viewing, stream_id = self._stream(params, client)
                viewing.resume(stream_id)
            case "rois.stream.disconnect_stream":
                viewing, stream_id = self._stream(params, client)
                viewing.disconnect(stream_id)
            case "rois.stream.report_playout":
                pass  # what is heard comes from the game engine itself: nothing here waits for it
            case HolderNotification.method:
                pass  # nothing here depends on who holds what
            case _:
                self._signal(method, params, client)
        return {}

    def _signal(self, method: str, params: Mapping[str, Any], client: Client) -> None:
        viewing = self._viewings.get(client)
        if viewing is None:
            raise media_errors.UnknownPeer("there is no such peer connection")
        match method:
            case Answer.method:
                viewing.answer(Answer.model_validate(params))
            case Candidate.method:
                viewing.candidate(Candidate.model_validate(params))
            case Restart.method:
                restart = RestartFromGateway.model_validate(params)
                if restart.ice_servers is not None:
                    viewing.ice_servers = restart.ice_servers
                viewing.restart(restart.peer_id)
            case Bye.method:
                bye = Bye.model_validate(params)
                viewing.end_peer(bye.peer_id, bye.reason)
            case _:
                raise Unsupported(f"there is no method {method}")

    def _stream(self, params: Mapping[str, Any], client: Client) -> tuple[Viewing, str]:
        stream_id = StreamParams.model_validate(params).stream_id
        viewing = self._viewings.get(client)
        if viewing is None:
            raise media_errors.UnknownStream("there is no such stream")
        return viewing, stream_id

    def _connect(self, params: ConnectFromGateway, client: Client) -> dict[str, Any]:
        kind = self._kinds.get(params.component_ref)
        if kind is None:
            raise Unsupported(f"{params.component_ref} has no streams")
        # What the application can decode is between its browser and the game engine.
        read_parameter(params.parameters, "encoding_parameters", EncodingParameters)
        direction = read_parameter(params.parameters, "transport_parameters", TransportParameters).direction
        if direction != "recvonly":
            raise Unsupported(f"{params.component_ref} has no streams of direction {direction!r}: recvonly")
        if self._streamer() is None:
            raise ComponentFailed(self._absent())
        viewing = self._viewings.get(client) or self._open(client, params.may_bind)
        # Its role may have changed since its first stream.
        self._may_bind[client] = params.may_bind
        viewing.ice_servers = params.ice_servers
        stream_id = new_id(self._engine_id)
        viewing.connect(stream_id, params.component_ref, kind)
        return {"stream_id": stream_id}

    def _open(self, client: Client, may_bind: bool) -> Viewing:
        if not self._has_room(may_bind):
            self._viewings = {each: viewing for each, viewing in self._viewings.items() if not viewing.is_over}
            self._may_bind = {each: self._may_bind[each] for each in self._viewings}
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

        viewing = self._viewings[client] = Viewing(
            lambda: new_id(self._engine_id), self._streamer, send, changed, self._clock.now, self._permits
        )
        return viewing

    def _displace(self, may_bind: bool) -> None:
        waits = ((each, viewing.unanswered_for()) for each, viewing in self._viewings.items())
        unanswered = {each: seconds for each, seconds in waits if seconds is not None}
        late = self._places.displaced(self._may_bind, unanswered, may_bind)
        if late is None:
            raise OutOfResources(
                f"{len(self._viewings)} of at most {self._places.applications} applications are served"
            )
        del self._may_bind[late]
        self._viewings.pop(late).close("its offer was not answered in time, and another application needs the place")

    def _has_room(self, may_bind: bool) -> bool:
        return self._places.has_room(self._may_bind.values(), may_bind)

    def _permits(self, candidate: str) -> bool:
        return read_candidate(candidate, "0", self._policy) is not None

    async def forget(self, client: Client) -> None:
        """End the streams of an application that is gone."""
        viewing = self._viewings.pop(client, None)
        self._may_bind.pop(client, None)
        if viewing is not None:
            viewing.close("the application is gone")

    def hear(self, heard: Heard) -> None:
        """Take what the game engine says to a player."""
        for viewing in tuple(self._viewings.values()):
            viewing.hear(heard)

    def lost(self) -> None:
        """The game engine is gone, and everything with it."""
        self._close("the game engine is gone")

    def _close(self, reason: str) -> None:
        for viewing in tuple(self._viewings.values()):
            viewing.close(reason)

    def look(self) -> None:
        """Look at deadlines of all applications, and tell what changed."""
        for viewing in tuple(self._viewings.values()):
            viewing.tick()

    async def run(self) -> None:
        """Look at the applications until cancelled; then everything ends."""
        try:
            while True:
                self.look()
                await self._clock.sleep_until(self._clock.now() + _TICK)
        finally:
            self._close("the engine stops")
