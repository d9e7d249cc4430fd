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
    """One streamer; a `Streamer`. It is asked for offers without data channels: see docs/facades.md.

    Args:
        send: sends it a message.
        tell: is told what it says to or about a player.
    """

    def __init__(self, send: Callable[[str], None], tell: Callable[[Heard], None]) -> None:
        self._send = send
        self._tell = tell
        self._ice_servers: tuple[IceServer, ...] = ()
        self._players: set[str] = set()
        self.name = ""

    @property
    def ready(self) -> bool:
        """Whether it has said who it is."""
        return bool(self.name)

    @property
    def has_room(self) -> bool:
        """Whether it takes a further player now: how many it can serve is its own business."""
        return self.ready

    def begin(self) -> None:
        """Greet it."""
        self._configure()
        self._say(Identify())

    def take(self, text: str) -> None:
        """Take one message; what is said of players that are gone is dropped, and so is what is not known.

        Raises:
            ProtocolError: it cannot be understood.
        """
        message = STREAMER_SAYS.read(text)
        match message:
            case EndpointId(id=name):
                self.name = name
                self._say(EndpointIdConfirm(committed_id=name))
            case Ping(time=time):
                self._say(Pong(time=time))
            case Offer(player_id=player_id, sdp=sdp) if player_id in self._players:
                self._tell(Offered(player_id, sdp))
            case IceCandidate(player_id=player_id, candidate=found) if player_id in self._players:
                self._tell(Found(player_id, found.candidate, found.sdp_mid or None, found.sdp_m_line_index))
            case DisconnectPlayer(player_id=player_id, reason=reason) if player_id in self._players:
                self._players.discard(player_id)
                self._tell(Left(player_id, reason or "the game engine has ended it"))

    def invite(self, player_id: str, ice_servers: Sequence[IceServer]) -> None:
        """Let it make an offer to a new player, over these STUN and TURN servers."""
        if tuple(ice_servers) != self._ice_servers:
            self._ice_servers = tuple(ice_servers)
            self._configure()
        self._players.add(player_id)
        self._say(PlayerConnected(player_id=player_id, data_channel=False))

    def answer(self, player_id: str, sdp: str) -> None:
        """Hand it a player's answer."""
        self._say(Answer(player_id=player_id, sdp=sdp))

    def find(self, found: Found) -> None:
        """Hand it a player's candidate."""
        candidate = RtcCandidate(
            candidate=found.candidate, sdp_mid=found.sdp_mid, sdp_m_line_index=found.sdp_m_line_index
        )
        self._say(IceCandidate(player_id=found.player_id, candidate=candidate))

    def dismiss(self, player_id: str) -> None:
        """Tell it that a player is gone, if it does not know that."""
        if player_id in self._players:
            self._players.discard(player_id)
            self._say(PlayerDisconnected(player_id=player_id))

    def _configure(self) -> None:
        options = PeerConnectionOptions(ice_servers=self._ice_servers)
        self._say(Config(peer_connection_options=options, protocol_version=_PROTOCOL_VERSION))

    def _say(self, message: Said) -> None:
        self._send(message.text())
