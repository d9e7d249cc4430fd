"""The signaling server of an Unreal Pixel Streaming streamer, without input or output. Pure."""

from collections.abc import Callable, Sequence
from typing import Final

from openrois_signaling.messages import IceServer

from openrois_avatar.facades.messages.pixel_streaming import (
    STREAMER_SAYS,
    Answer,
    Config,
    DisconnectPlayer,
    EndpointId,
    EndpointIdConfirm,
    IceCandidate,
    Identify,
    Offer,
    PeerConnectionOptions,
    Ping,
    PlayerConnected,
    PlayerDisconnected,
    Pong,
    RtcCandidate,
)
from openrois_avatar.facades.messages.reading import Said
from openrois_avatar.facades.streamer import Found, Heard, Left, Offered

__all__ = ["UnrealStreamer"]

_PROTOCOL_VERSION: Final = "1.3.0"
"""Of the signaling protocol that is spoken here."""


class UnrealStreamer:
    """One streamer; a `Streamer`. It is asked for offers without data channels: see docs/how-to/facades.md.

    Args:
        send: sends it a message.
        on_message: called with what it says to or about a player.
    """

    def __init__(self, send: Callable[[str], None], on_message: Callable[[Heard], None]) -> None:
        self._send = send
        self._on_message = on_message
        self._ice_servers: tuple[IceServer, ...] = ()
        self._players: set[str] = set()
        self.name = ""

    @property
    def ready(self) -> bool:
        """Whether it has sent its id."""
        return bool(self.name)

    @property
    def has_room(self) -> bool:
        """Whether it takes a further player now: it limits their number by itself."""
        return self.ready

    def begin(self) -> None:
        """Send the greeting."""
        self._configure()
        self._send_message(Identify())

    def handle_message(self, text: str) -> None:
        """Handle one message; messages about players that have left and unknown messages are dropped.

        Raises:
            ProtocolError: it is malformed.
        """
        message = STREAMER_SAYS.read(text)
        match message:
            case EndpointId(id=name):
                self.name = name
                self._send_message(EndpointIdConfirm(committed_id=name))
            case Ping(time=time):
                self._send_message(Pong(time=time))
            case Offer(player_id=player_id, sdp=sdp) if player_id in self._players:
                self._on_message(Offered(player_id, sdp))
            case IceCandidate(player_id=player_id, candidate=found) if player_id in self._players:
                self._on_message(Found(player_id, found.candidate, found.sdp_mid or None, found.sdp_m_line_index))
            case DisconnectPlayer(player_id=player_id, reason=reason) if player_id in self._players:
                self._players.discard(player_id)
                self._on_message(Left(player_id, reason or "the game engine has ended the connection"))

    def invite(self, player_id: str, ice_servers: Sequence[IceServer]) -> None:
        """Ask for an offer to a new player, with these STUN and TURN servers."""
        if tuple(ice_servers) != self._ice_servers:
            self._ice_servers = tuple(ice_servers)
            self._configure()
        self._players.add(player_id)
        self._send_message(PlayerConnected(player_id=player_id, data_channel=False))

    def send_answer(self, player_id: str, sdp: str) -> None:
        """Send a player's answer."""
        self._send_message(Answer(player_id=player_id, sdp=sdp))

    def send_candidate(self, found: Found) -> None:
        """Send a player's candidate."""
        candidate = RtcCandidate(
            candidate=found.candidate, sdp_mid=found.sdp_mid, sdp_m_line_index=found.sdp_m_line_index
        )
        self._send_message(IceCandidate(player_id=found.player_id, candidate=candidate))

    def dismiss(self, player_id: str) -> None:
        """Report that a player has left, unless the streamer knows that."""
        if player_id in self._players:
            self._players.discard(player_id)
            self._send_message(PlayerDisconnected(player_id=player_id))

    def _configure(self) -> None:
        options = PeerConnectionOptions(ice_servers=self._ice_servers)
        self._send_message(Config(peer_connection_options=options, protocol_version=_PROTOCOL_VERSION))

    def _send_message(self, message: Said) -> None:
        self._send(message.text())
