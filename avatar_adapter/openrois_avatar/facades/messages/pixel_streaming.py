"""The signaling messages between an Unreal Pixel Streaming streamer and its signaling server, in both directions. Pure.

They are JSON objects in text frames of a WebSocket. The server greets with `config` and `identify`, the streamer says
its `endpointId`, which is confirmed. From then on the server tells of players; the streamer offers to each of them.
"""

from typing import Annotated, Any, Final, TypeAlias

from openrois_signaling.messages import IceServer
from pydantic import BeforeValidator, Field

from openrois_avatar.facades.messages.reading import CandidateText, Mid, Name, Part, Reason, Said, Sdp, Vocabulary

__all__ = [
    "SERVER_SAYS",
    "STREAMER_SAYS",
    "Answer",
    "Config",
    "DisconnectPlayer",
    "EndpointId",
    "EndpointIdConfirm",
    "ForServer",
    "ForStreamer",
    "IceCandidate",
    "Identify",
    "LayerPreference",
    "Offer",
    "PeerConnectionOptions",
    "Ping",
    "PlayerConnected",
    "PlayerDisconnected",
    "Pong",
    "RtcCandidate",
]

Time = Annotated[int | float, Field(ge=-(2**63), le=2**63)]
"""Milliseconds of the asking side's clock; they come back as they were."""


def _as_ours(server: Any) -> Any:
    """Convert an RTCIceServer of W3C: a single URL becomes a list, and unknown members are left out."""
    if not isinstance(server, dict):
        return server
    known = {name: member for name, member in server.items() if name in IceServer.model_fields}
    return {**known, "urls": [known["urls"]]} if isinstance(known.get("urls"), str) else known


class PeerConnectionOptions(Part):
    """The part of W3C's RTCConfiguration that matters: which STUN and TURN servers to use."""

    ice_servers: Annotated[
        tuple[Annotated[IceServer, BeforeValidator(_as_ours)], ...], Field(strict=False, max_length=32)
    ] = ()


class Config(Said):
    """Server to streamer: how peer connections are to be made from now on."""

    type = "config"
    peer_connection_options: PeerConnectionOptions = PeerConnectionOptions()
    protocol_version: Name | None = None


class Identify(Said):
    """Server to streamer: a request for its id."""

    type = "identify"


class EndpointId(Said):
    """Streamer to server: the id that it wants to have."""

    type = "endpointId"
    id: Name
    protocol_version: Name | None = None


class EndpointIdConfirm(Said):
    """Server to streamer: the id that it has."""

    type = "endpointIdConfirm"
    committed_id: Name


class PlayerConnected(Said):
    """Server to streamer: a player has connected; `send_offer`: the streamer has to offer."""

    type = "playerConnected"
    player_id: Name
    data_channel: bool = True
    sfu: bool = False
    send_offer: bool = True


class PlayerDisconnected(Said):
    """Server to streamer: a player has disconnected."""

    type = "playerDisconnected"
    player_id: Name


class Offer(Said):
    """A description; from the streamer to a player, or the other way where players offer."""

    type = "offer"
    player_id: Name
    sdp: Sdp


class Answer(Said):
    """The description that answers an offer."""

    type = "answer"
    player_id: Name
    sdp: Sdp


class RtcCandidate(Part):
    """W3C's RTCIceCandidateInit; an empty `candidate` says that there are no more."""

    candidate: CandidateText
    sdp_mid: Mid | None = None
    sdp_m_line_index: Annotated[int, Field(ge=0, le=2**16 - 1)] | None = None
    username_fragment: Annotated[str, Field(max_length=256)] | None = None


class IceCandidate(Said):
    """A candidate of either side."""

    type = "iceCandidate"
    player_id: Name
    candidate: RtcCandidate


class DisconnectPlayer(Said):
    """Streamer to server: disconnect a player."""

    type = "disconnectPlayer"
    player_id: Name
    reason: Reason = ""


class LayerPreference(Said):
    """Server to streamer: which layer of a scalable encoding a player wants."""

    type = "layerPreference"
    player_id: Name
    spatial_layer: int
    temporal_layer: int


class Ping(Said):
    """A keep-alive request of either side."""

    type = "ping"
    time: Time


class Pong(Said):
    """The answer to a ping."""

    type = "pong"
    time: Time


ForServer: TypeAlias = EndpointId | Offer | Answer | IceCandidate | DisconnectPlayer | Ping | Pong
ForStreamer: TypeAlias = (
    Config
    | Identify
    | EndpointIdConfirm
    | PlayerConnected
    | PlayerDisconnected
    | Offer
    | Answer
    | IceCandidate
    | LayerPreference
    | Ping
    | Pong
)

STREAMER_SAYS: Final[Vocabulary[ForServer]] = Vocabulary(
    EndpointId, Offer, Answer, IceCandidate, DisconnectPlayer, Ping, Pong
)
"""The messages of a streamer to its signaling server."""

SERVER_SAYS: Final[Vocabulary[ForStreamer]] = Vocabulary(
    Config,
    Identify,
    EndpointIdConfirm,
    PlayerConnected,
    PlayerDisconnected,
    Offer,
    Answer,
    IceCandidate,
    LayerPreference,
    Ping,
    Pong,
)
"""The messages of a signaling server to a streamer."""
