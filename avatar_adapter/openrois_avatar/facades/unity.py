"""The signaling server of a Unity Render Streaming sender in private mode, without input or output. Pure.

A sender asks for connections by ids of its own, and offers as soon as the server confirms a connection. So a connection
is confirmed only when a viewer comes: each requested connection is a place for one player.
"""

from collections.abc import Callable, Sequence
from typing import Final

from openrois_signaling.messages import IceServer

from openrois_avatar.facades.messages.reading import ProtocolError, Said
from openrois_avatar.facades.messages.render_streaming import (
    SENDER_SAYS,
    Answer,
    Candidate,
    Connect,
    Connected,
    Description,
    Disconnect,
    Failure,
    Offer,
)
from openrois_avatar.facades.messages.render_streaming import Found as FoundData
from openrois_avatar.facades.streamer import Found, Heard, Left, NoRoom, Offered

__all__ = ["CONNECTIONS_LIMIT", "UnitySender"]

CONNECTIONS_LIMIT: Final = 64
"""Most connections that a sender may ask for."""


class UnitySender:
    """One sender; a `Streamer`. It takes as many players as it has asked for connections.

    Args:
        send: sends it a message.
        on_message: called with what it says to or about a player.
        epoch: the time, in seconds since the epoch.
    """

    name = "Unity"

    def __init__(
        self, send: Callable[[str], None], on_message: Callable[[Heard], None], epoch: Callable[[], float]
    ) -> None:
        self._send = send
        self._on_message = on_message
        self._epoch = epoch
        self._places: dict[str, str] = {}
        """The player id of each connection; empty while it is free."""

    @property
    def ready(self) -> bool:
        """Whether it has asked for a connection."""
        return bool(self._places)

    @property
    def has_room(self) -> bool:
        """Whether one of its connections is not in use."""
        return "" in self._places.values()

    def begin(self) -> None:
        """Send nothing: the protocol has no greeting."""

    def handle_message(self, text: str) -> None:
        """Handle one message; messages about closed connections and unknown messages are dropped.

        Raises:
            ProtocolError: it is malformed, or it is an answer, without an offer of this side.
        """
        message = SENDER_SAYS.read(text)
        match message:
            case Connect(connection_id=connection_id):
                self._reserve(connection_id)
            case Disconnect(connection_id=connection_id):
                player_id = self._places.pop(connection_id, "")
                self._send_message(Disconnect(connection_id=connection_id))
                if player_id:
                    self._on_message(Left(player_id, "the game engine has ended the connection"))
            case Offer(data=description) if player_id := self._places.get(message.connection_id, ""):
                self._on_message(Offered(player_id, description.sdp))
            case Candidate(data=found) if player_id := self._places.get(message.connection_id, ""):
                self._on_message(Found(player_id, found.candidate, found.sdp_mid or None, found.sdp_m_line_index))
            case Answer():
                raise ProtocolError("answer: the server has made no offer")

    def invite(self, player_id: str, ice_servers: Sequence[IceServer]) -> None:
        """Ask for an offer to a new player; its STUN and TURN servers are set in Unity, not here.

        Raises:
            NoRoom: all connections that it has asked for are in use.
        """
        connection_id = next((each for each, player in self._places.items() if not player), None)
        if connection_id is None:
            raise NoRoom("all connections of the game engine are in use; each takes one viewer")
        self._places[connection_id] = player_id
        # This side never offers, so politeness does not matter.
        self._send_message(Connected(connection_id=connection_id, polite=True))

    def send_answer(self, player_id: str, sdp: str) -> None:
        """Send a player's answer."""
        for connection_id in self._of(player_id):
            self._send_message(Answer(from_=connection_id, data=Description(sdp=sdp, datetime=self._milliseconds())))

    def send_candidate(self, found: Found) -> None:
        """Send a player's candidate."""
        data = FoundData(
            candidate=found.candidate,
            sdp_mid=found.sdp_mid,
            sdp_m_line_index=found.sdp_m_line_index,
            datetime=self._milliseconds(),
        )
        for connection_id in self._of(found.player_id):
            self._send_message(Candidate(from_=connection_id, data=data))

    def dismiss(self, player_id: str) -> None:
        """Report that a player has left, unless the sender knows that; it may ask for the connection again."""
        for connection_id in self._of(player_id):
            del self._places[connection_id]
            self._send_message(Disconnect(connection_id=connection_id))

    def _reserve(self, connection_id: str) -> None:
        if self._places.get(connection_id) == "":
            return  # it waits already; asking again is allowed
        if connection_id in self._places:
            self._send_message(Failure(message=f"{connection_id}: this connection is in use already"))
        elif len(self._places) >= CONNECTIONS_LIMIT:
            self._send_message(Failure(message=f"{CONNECTIONS_LIMIT} connections exist already, which is the limit"))
        else:
            self._places[connection_id] = ""

    def _of(self, player_id: str) -> list[str]:
        return [each for each, player in self._places.items() if player == player_id]

    def _milliseconds(self) -> int:
        return round(self._epoch() * 1000)

    def _send_message(self, message: Said) -> None:
        self._send(message.text())
