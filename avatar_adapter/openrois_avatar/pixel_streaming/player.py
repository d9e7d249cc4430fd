"""One player of Pixel Streaming, as an application of the avatar's streams."""

import json
import logging
from collections.abc import Awaitable, Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any, Final, TypeAlias

from openrois_media.streaming_interface import OwnChannels, StreamingInterface
from openrois_signaling.messages import Answer, Bye, Candidate, IceServer, Offer
from openrois_streaming.clock import MediaClock
from openrois_streaming.errors import UnknownStream
from openrois_streaming.input.messages import Message as InputMessage
from openrois_streaming.input.reader import Label
from openrois_streaming.peer.data_channel import AnnouncedChannel

from openrois.contract import Client
from openrois.errors import RoISError
from openrois.types.streams import STREAM_METHODS
from openrois_avatar.facades.messages import pixel_streaming as wire
from openrois_avatar.facades.messages.reading import Said
from openrois_avatar.pixel_streaming.conversation import Conversation
from openrois_avatar.pixel_streaming.guests import Guests
from openrois_avatar.pixel_streaming.player_input import PlayerInput
from openrois_avatar.pixel_streaming.protocol import MESSAGE_LIMIT

__all__ = ["Player", "Step"]

_log = logging.getLogger(__name__)

_LABEL: Final = "datachannel"

Step: TypeAlias = Callable[[], Awaitable[None]]


class Player:
    """One player, from its connection to its end; a `Guest`, an `InputSink`, and the `Stage` of its conversation.

    Args:
        player_id: its id at the signaling server.
        streams: of the avatar.
        components: the streaming components that it is sent: of the picture, and of the sound.
        guests: chooses the player that operates; None: no player does.
        say: sends the signaling server a message.
        later: queues a step after the earlier ones.
        clock: the media clock.
    """

    def __init__(
        self,
        player_id: str,
        streams: StreamingInterface,
        components: Sequence[str],
        guests: Guests | None,
        say: Callable[[Said], None],
        later: Callable[[Step], None],
        clock: MediaClock,
    ) -> None:
        self.player_id = player_id
        self.over = False
        """Whether its peer connection has ended."""
        self._streams = streams
        self._components = components
        self._guests = guests
        self._say = say
        self._later = later
        self._client = Client(f"player {player_id}", self._on_notification)
        self._conversation = Conversation(self, clock.now, clock.wall)
        self._send: Callable[[str | bytes], None] = lambda _message: None
        self._offer: Offer | None = None
        self._stream_ids: list[str] = []
        self._suspended = False
        self._wanted = True

    async def connect(self, ice_servers: Sequence[IceServer]) -> None:
        """Offer picture, sound, and a data channel.

        Raises:
            RoISError: the player cannot be served; the text says why.
        """
        channel = AnnouncedChannel(_LABEL, MESSAGE_LIMIT, self._opened)
        self._streams.expect(self._client, OwnChannels(channel, self._open_input))
        transport = {"name": "transport_parameters", "data_type_ref": "", "value": json.dumps({"input": True})}
        for component_ref in self._components:
            params = {
                "component_ref": component_ref,
                "parameters": [transport],
                "ice_servers": [server.wire() for server in ice_servers],
            }
            connected = await self._streams.call(STREAM_METHODS["connect_stream"], params, self._client)
            self._stream_ids.append(connected["stream_id"])

    async def apply_answer(self, sdp: str) -> None:
        """Apply its answer to the newest offer. An invalid one ends the player."""
        if self._offer is not None:
            await self._call_streams(Answer.method, {**self._newest(self._offer), "sdp": sdp})

    async def add_candidate(self, found: wire.RtcCandidate) -> None:
        """Handle its candidate. An invalid one is dropped."""
        if self._offer is not None and found.candidate:
            await self._call_streams(
                Candidate.method,
                {
                    **self._newest(self._offer),
                    "candidate": found.candidate,
                    "sdp_mid": found.sdp_mid or None,
                    "sdp_m_line_index": found.sdp_m_line_index or 0,
                },
            )

    async def follow(self) -> None:
        """Suspend or resume its streams as it wants, if its peer connection has not ended."""
        if self._suspended is self._wanted and not self.over:
            self._suspended = not self._wanted
            method = STREAM_METHODS["suspend_stream" if self._suspended else "resume_stream"]
            for stream_id in self._stream_ids:
                await self._call_streams(method, {"stream_id": stream_id})

    async def leave(self) -> None:
        """End its streams."""
        self.over = True
        self.input_lost("the player is gone")
        await self._streams.forget_client(self._client)
        _log.info("player %s is gone: %s", self.player_id, self._conversation.figures)

    def send(self, message: bytes) -> None:
        """Send a message over its data channel; lost where that is not open."""
        self._send(message)

    def show_anew(self) -> None:
        """Send a key frame."""
        for stream_id in self._stream_ids[:1]:
            with suppress(UnknownStream):
                self._streams.request_key_frame(self._client, stream_id)

    def play(self, on: bool) -> None:
        """Play or suspend its streams."""
        self._wanted = on
        self._later(self.follow)

    def operate(self, message: InputMessage, player_input: PlayerInput) -> None:
        """Handle its input."""
        if self._guests is None or not self._guests.operate(self, message, player_input):
            self._conversation.figures.refused += 1

    def own(self, on: bool) -> None:
        """Report whether it operates the avatar from now on."""
        self._conversation.own(on)

    def input_came(self, _label: Label, data: str | bytes) -> None:
        """Handle a message of its data channel."""
        self._conversation.handle_message(data)

    def input_lost(self, reason: str) -> None:
        """Note that its data channel is closed."""
        if self._guests is not None:
            self._guests.leave(self, reason)

    @staticmethod
    def _newest(offer: Offer) -> dict[str, Any]:
        return {"peer_id": offer.peer_id, "generation": offer.generation}

    def _open_input(self, send: Callable[[str | bytes], None]) -> "Player":
        self._send = send
        return self

    def _opened(self) -> None:
        self._conversation.opened()
        if self._guests is not None:
            self._guests.join(self)

    async def _call_streams(self, method: str, params: Mapping[str, Any]) -> None:
        try:
            await self._streams.call(method, params, self._client)
        except RoISError as error:
            _log.info("player %s: %s", self.player_id, error)

    def _on_notification(self, method: str, params: Mapping[str, Any]) -> None:
        match method:
            case Offer.method:
                self._offer = Offer.model_validate(params)
                self._say(wire.Offer(player_id=self.player_id, sdp=self._offer.sdp))
            case Candidate.method:
                found = Candidate.model_validate(params)
                if found.candidate:
                    candidate = wire.RtcCandidate(
                        candidate=found.candidate, sdp_mid=found.sdp_mid, sdp_m_line_index=found.sdp_m_line_index
                    )
                    self._say(wire.IceCandidate(player_id=self.player_id, candidate=candidate))
            case Bye.method if not self.over:
                self.over = True
                self._later(self.follow)
                reason = Bye.model_validate(params).reason
                self._say(wire.DisconnectPlayer(player_id=self.player_id, reason=reason))
            case _:
                pass  # it observes the status of its streams by itself
