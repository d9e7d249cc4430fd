"""The signaling messages between a Unity Render Streaming sender and its signaling server, in both directions. Pure.

They are JSON objects in text frames of a WebSocket. In private mode a sender asks for a connection by an id that both
ends know, and offers when the server says that it is there. What the ends of a connection say to each other is wrapped
in `data`; a sender names the connection in there, a server beside it, in `from`.
"""

from typing import Annotated, Final, Self, TypeAlias

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from openrois_avatar.facades.messages.reading import CandidateText, Mid, Part, Reason, Said, Sdp, Vocabulary
from openrois_avatar.facades.messages.reading import Name as ConnectionId

__all__ = [
    "SENDER_SAYS",
    "SERVER_SAYS",
    "Answer",
    "Candidate",
    "Connect",
    "Connected",
    "Description",
    "Disconnect",
    "Failure",
    "ForSender",
    "ForServer",
    "Found",
    "Offer",
]

MaybeId = Annotated[str, Field(max_length=256)]
"""An id, or nothing: Unity's serializer writes an empty text for what is absent."""


class Connect(Said):
    """Sender to server: a request for a connection."""

    type = "connect"
    connection_id: ConnectionId


class Connected(Said):
    """Server to sender: the connection is established. Where both offer at once, the polite one yields."""

    type = "connect"
    connection_id: ConnectionId
    polite: bool


class Disconnect(Said):
    """Either way: the connection has ended."""

    type = "disconnect"
    connection_id: ConnectionId


class Description(Part):
    """The description of an offer or answer; `datetime` is epoch milliseconds at the server."""

    sdp: Sdp
    connection_id: MaybeId | None = None
    datetime: int | None = None
    polite: bool | None = None


class Found(Part):
    """A candidate as W3C's RTCIceCandidateInit has it; `datetime` is epoch milliseconds at the server."""

    candidate: CandidateText
    sdp_mid: Mid | None = None
    sdp_m_line_index: Annotated[int, Field(ge=0, le=2**16 - 1)] | None = None
    connection_id: MaybeId | None = None
    datetime: int | None = None


class _Wrapped(Said):
    """A message between the ends of a connection."""

    data: Description | Found
    from_: Annotated[MaybeId, Field(alias="from")] = ""
    to: MaybeId = ""

    @property
    def connection_id(self) -> str:
        """The connection of the message."""
        return self.data.connection_id or self.from_

    @model_validator(mode="after")
    def _names_a_connection(self) -> Self:
        if not self.connection_id:
            raise PydanticCustomError("no_connection", "neither data.connectionId nor from")
        return self


class Offer(_Wrapped):
    """A description that is to be answered."""

    type = "offer"
    data: Description


class Answer(_Wrapped):
    """The description that answers an offer."""

    type = "answer"
    data: Description


class Candidate(_Wrapped):
    """A candidate of either end."""

    type = "candidate"
    data: Found


class Failure(Said):
    """Server to sender: a request was refused."""

    type = "error"
    message: Reason


ForServer: TypeAlias = Connect | Disconnect | Offer | Answer | Candidate
ForSender: TypeAlias = Connected | Disconnect | Offer | Answer | Candidate | Failure

SENDER_SAYS: Final[Vocabulary[ForServer]] = Vocabulary(Connect, Disconnect, Offer, Answer, Candidate)
"""The messages of a sender to its signaling server."""

SERVER_SAYS: Final[Vocabulary[ForSender]] = Vocabulary(Connected, Disconnect, Offer, Answer, Candidate, Failure)
"""The messages of a signaling server to a sender."""
