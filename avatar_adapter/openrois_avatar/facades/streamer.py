"""The interface of a game engine that does WebRTC itself to its signaling server, for any protocol. Pure."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from openrois_signaling.messages import IceServer

__all__ = ["Found", "Heard", "Left", "NoRoom", "NotOffered", "Offered", "Streamer", "StreamerFactory"]


class NoRoom(Exception):
    """The game engine takes no further player; the text is a sentence for a person."""


class NotOffered(Exception):
    """The game engine does not offer such streams; the text is a sentence for a person."""


@dataclass(frozen=True, slots=True)
class Offered:
    """An offer of the game engine to a player."""

    player_id: str
    sdp: str


@dataclass(frozen=True, slots=True)
class Found:
    """A candidate of the game engine or of a player; an empty one is the end of candidates."""

    player_id: str
    candidate: str
    sdp_mid: str | None
    sdp_m_line_index: int | None


@dataclass(frozen=True, slots=True)
class Left:
    """The game engine has ended a player; `reason` is a sentence for a person."""

    player_id: str
    reason: str


Heard: TypeAlias = Offered | Found | Left
"""A message of a game engine to or about a player."""


class Streamer(Protocol):
    """One connection of a game engine. It is used in the event loop; no method waits.

    A player is one peer connection between the game engine and an application. Only adapter and engine know its id.
    """

    @property
    def ready(self) -> bool:
        """Whether it has identified itself and is ready for players."""
        ...

    @property
    def has_room(self) -> bool:
        """Whether it takes a further player now."""
        ...

    @property
    def name(self) -> str:
        """Its own name."""
        ...

    def begin(self) -> None:
        """Send the greeting."""
        ...

    def handle_message(self, text: str) -> None:
        """Handle one message.

        Raises:
            ProtocolError: it is malformed.
        """
        ...

    def invite(self, player_id: str, ice_servers: Sequence[IceServer]) -> None:
        """Ask for an offer to a new player.

        Raises:
            NoRoom: it takes no further player now.
        """
        ...

    def send_answer(self, player_id: str, sdp: str) -> None:
        """Send a player's answer."""
        ...

    def send_candidate(self, found: Found) -> None:
        """Send a player's candidate."""
        ...

    def dismiss(self, player_id: str) -> None:
        """Report that a player has left."""
        ...


StreamerFactory: TypeAlias = Callable[[Callable[[str], None], Callable[[Heard], None]], Streamer]
"""Makes a streamer of the functions that send it a message and handle its messages."""
