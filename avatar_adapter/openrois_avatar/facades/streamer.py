"""A game engine that does WebRTC itself, as its signaling server sees it, whichever protocol it speaks. Pure."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from openrois_signaling.messages import IceServer

__all__ = ["Found", "Heard", "Left", "NoRoom", "NotOffered", "Offered", "Streamer", "StreamerFactory"]


class NoRoom(Exception):
    """The game engine takes no further player; the text is a sentence for a person."""


class NotOffered(Exception):
    """The game engine does not send that; the text is a sentence for a person."""


@dataclass(frozen=True, slots=True)
class Offered:
    """The game engine offers a player its pictures and sound."""

    player_id: str
    sdp: str


@dataclass(frozen=True, slots=True)
class Found:
    """A candidate of the game engine or of a player; an empty one says that there are no more."""

    player_id: str
    candidate: str
    sdp_mid: str | None
    sdp_m_line_index: int | None


@dataclass(frozen=True, slots=True)
class Left:
    """The game engine has ended what it had with a player; `reason` is a sentence for a person."""

    player_id: str
    reason: str


Heard: TypeAlias = Offered | Found | Left
"""What a game engine says to or about a player."""


class Streamer(Protocol):
    """One connection of a game engine. It is used in the event loop; nothing here waits.

    A player is one peer connection between the game engine and an application. Its id is known to these two alone.
    """

    @property
    def ready(self) -> bool:
        """Whether it has said who it is and can be sent players."""
        ...

    @property
    def has_room(self) -> bool:
        """Whether it takes a further player now."""
        ...

    @property
    def name(self) -> str:
        """What it calls itself."""
        ...

    def begin(self) -> None:
        """It is there: greet it."""
        ...

    def take(self, text: str) -> None:
        """Take one message.

        Raises:
            ProtocolError: it cannot be understood.
        """
        ...

    def invite(self, player_id: str, ice_servers: Sequence[IceServer]) -> None:
        """Let it make an offer to a new player.

        Raises:
            NoRoom: it takes no further player now.
        """
        ...

    def answer(self, player_id: str, sdp: str) -> None:
        """Hand it a player's answer."""
        ...

    def find(self, found: Found) -> None:
        """Hand it a player's candidate."""
        ...

    def dismiss(self, player_id: str) -> None:
        """Tell it that a player is gone."""
        ...


StreamerFactory: TypeAlias = Callable[[Callable[[str], None], Callable[[Heard], None]], Streamer]
"""Makes one of what sends it a message, and of what is told what it says."""
