"""The messages of the signaling channel, as they stand in the params of the `signaling.*` methods. Pure.

All are immutable and refuse unknown fields. `method` of a message is its JSON-RPC method, `wire()` its params.
"""

from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, FailFast, Field, model_validator
from pydantic_core import PydanticCustomError

SDP_LIMIT = 48 * 1024
"""Bytes of one session description; Chromium's answer to 16 sections has 20 kB."""

CANDIDATE_LIMIT = 1024
"""Bytes of one candidate line; with IPv6 addresses and all extensions it has 250."""

CANDIDATES_LIMIT = 64
"""Candidates that one peer may send, over all its generations."""

SECTIONS_LIMIT = 16
"""m-sections of one peer connection; they are reused, never removed."""

ID_LIMIT = 256
"""Characters of a stream id or peer id, which are `<engine_id>/<32 hexadecimal digits>`."""

REASON_LIMIT = 256
"""Characters of the reason in a bye."""

MID_LIMIT = 64
"""Characters of a mid (RFC 8843 recommends at most 3)."""

GENERATION_LIMIT = 2**31 - 1
"""The greatest generation; a peer that renegotiates every second reaches it after 68 years."""

_UINT32 = 2**32 - 1  # of an SSRC and of an RTP timestamp (RFC 3550 section 5.1)
_CLOCK_RATE = 1_000_000  # Hz; video has 90,000
_EXACT = 2**53 - 1  # the greatest integer that JavaScript counts exactly

TOO_LONG = "too_long_for_signaling"
"""The pydantic error type of a value that has the right shape and exceeds a limit of this module."""

MediaKind = Literal["audio", "video"]
Direction = Literal["recvonly", "sendonly", "sendrecv"]
"""Seen from the application: `recvonly` is a stream that the application receives."""


def _at_most(limit: int) -> AfterValidator:
    """Refuse text of more bytes; a schema, which can count characters only, says so with `maxLength`."""

    def check(text: str) -> str:
        if len(text.encode()) > limit:
            raise PydanticCustomError(TOO_LONG, "more than {limit} bytes", {"limit": limit})
        return text

    return AfterValidator(check)


Identifier = Annotated[str, Field(min_length=1, json_schema_extra={"maxLength": ID_LIMIT}), _at_most(ID_LIMIT)]
Mid = Annotated[str, Field(min_length=1, json_schema_extra={"maxLength": MID_LIMIT}), _at_most(MID_LIMIT)]
Sdp = Annotated[str, Field(min_length=1, json_schema_extra={"maxLength": SDP_LIMIT}), _at_most(SDP_LIMIT)]
Generation = Annotated[int, Field(strict=True, ge=1, le=GENERATION_LIMIT)]


class _Value(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class _Message(_Value):
    method: ClassVar[str]
    peer_id: Identifier

    def wire(self) -> dict[str, Any]:
        """The params as JSON values, without optional fields that are absent."""
        return self.model_dump(mode="json", exclude_none=True)


class StreamSection(_Value):
    """Which m-section of an offer carries which stream."""

    mid: Mid
    stream_id: Identifier
    component_ref: Annotated[str, Field(min_length=1, max_length=1024)]
    kind: MediaKind
    direction: Direction


class Offer(_Message):
    """The engine's description number `generation` of the peer connection `peer_id`; `replaces` names the one it ends.

    `streams` lists the sections that carry a stream now; sections that are not listed are idle.
    """

    method: ClassVar[str] = "signaling.offer"
    generation: Generation
    sdp: Sdp
    streams: Annotated[tuple[StreamSection, ...], FailFast(), Field(strict=False, max_length=SECTIONS_LIMIT)]
    replaces: Identifier | None = None


class Answer(_Message):
    """The application's description for the offer of the same generation."""

    method: ClassVar[str] = "signaling.answer"
    generation: Generation
    sdp: Sdp


class Candidate(_Message):
    """One ICE candidate of the sender, belonging to the description of `generation`.

    `candidate` is an RFC 8839 candidate-attribute as `RTCIceCandidate.candidate` gives it; None or "" says that there
    will be no more. A candidate names its m-section by `sdp_mid`, `sdp_m_line_index`, or both.
    """

    method: ClassVar[str] = "signaling.candidate"
    generation: Generation
    candidate: Annotated[str, Field(json_schema_extra={"maxLength": CANDIDATE_LIMIT}), _at_most(CANDIDATE_LIMIT)] | None
    sdp_mid: Annotated[str, Field(json_schema_extra={"maxLength": MID_LIMIT}), _at_most(MID_LIMIT)] | None = None
    sdp_m_line_index: Annotated[int, Field(strict=True, ge=0, le=2**16 - 1)] | None = None

    @model_validator(mode="after")
    def _names_a_section(self) -> Self:
        if self.candidate and self.sdp_mid is None and self.sdp_m_line_index is None:
            raise PydanticCustomError("no_section", "neither sdp_mid nor sdp_m_line_index")
        return self

    def wire(self) -> dict[str, Any]:
        """The params as JSON values; `candidate` stands there also when it is None."""
        return super().wire() | {"candidate": self.candidate}


class Restart(_Message):
    """The application's request for a new peer connection in place of `peer_id`."""

    method: ClassVar[str] = "signaling.restart"


class Bye(_Message):
    """The deliberate end of a peer connection; `reason` is a sentence for a person."""

    method: ClassVar[str] = "signaling.bye"
    reason: Annotated[str, Field(max_length=REASON_LIMIT)]


class SenderClock(_Value):
    """What one sender's RTP timestamps mean: a frame with the timestamp `rtp_origin` was captured at `wall`.

    `wall` is in milliseconds since the epoch, on the engine's clock; timestamps count `clock_rate` units a second and
    wrap around at 2**32.
    """

    mid: Mid
    ssrc: Annotated[int, Field(strict=True, ge=0, le=_UINT32)]
    clock_rate: Annotated[int, Field(strict=True, ge=1, le=_CLOCK_RATE)]
    rtp_origin: Annotated[int, Field(strict=True, ge=0, le=_UINT32)]
    wall: Annotated[int, Field(strict=True, ge=0, le=_EXACT)]


class CaptureClocks(_Message):
    """The clocks of the senders of a peer connection, each by the m-section and the SSRC that it sends with.

    They are sent when media begins to pass and every few seconds after that, because the engine's clock may be set.
    """

    method: ClassVar[str] = "signaling.capture_clocks"
    senders: Annotated[tuple[SenderClock, ...], FailFast(), Field(strict=False, max_length=SECTIONS_LIMIT)]


Downward: TypeAlias = Offer | Candidate | Bye | CaptureClocks
"""The messages of an engine to an application."""


class IceServer(_Value):
    """A STUN or TURN server in the form of the W3C dictionary RTCIceServer, with password credentials only."""

    urls: Annotated[tuple[Annotated[str, Field(min_length=1, max_length=512)], ...], Field(strict=False, min_length=1)]
    username: Annotated[str, Field(max_length=512)] | None = None
    credential: Annotated[str, Field(max_length=512)] | None = Field(default=None, repr=False)

    def wire(self) -> dict[str, Any]:
        """The dictionary as JSON values, without credentials where there are none."""
        return self.model_dump(mode="json", exclude_none=True)
