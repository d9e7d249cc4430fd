"""Checks of an application's SDP before it reaches aiortc.

aiortc's parser raises any exception on hostile text, it applies an answer section by section, and it keeps only the
last section's candidates of a bundle. So an answer is taken apart here: only known attributes pass, sections must be
the offered ones in the offered order, and candidates are removed, to be added one by one. An application may do less in
a section than was offered (the operator denied the microphone), never more.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from aiortc import RTCDtlsFingerprint, RTCIceCandidate
from aiortc.sdp import MediaDescription, SessionDescription, candidate_from_sdp
from openrois_signaling.messages import CANDIDATES_LIMIT, Direction

from openrois_streaming.errors import InvalidCandidate, InvalidDescription
from openrois_streaming.network.policy import CandidatePolicy

LINES_LIMIT = 128
"""Lines of one section that pass; the time of aiortc's parser grows with their square. Chromium has 40."""

_LINE = re.compile(r"[a-z]=[ -~]*")
_MEDIA = re.compile(r"m=(audio|video) (\d{1,5}) [A-Z/]{1,32}( \d{1,3}){1,32}")
_CHANNELS = re.compile(r"m=(application) (\d{1,5}) UDP/DTLS/SCTP webrtc-datachannel")
_MID = re.compile(r"(?m)^a=mid:(\S+)")
_SCTP_PORT = re.compile(r"a=sctp-port:[1-9]\d{0,4}")
_UFRAG = re.compile(r"[A-Za-z0-9+/]{4,256}")  # RFC 8839 section 5.4
_PASSWORD = re.compile(r"[A-Za-z0-9+/]{22,256}")
_PAYLOAD_TYPES = frozenset((*range(64), *range(96, 128)))  # the others are taken for RTCP (RFC 5761 section 4)
_EXTENSION_IDS = range(1, 15)  # of the one-byte form, RFC 8285 section 4.2
_HASHES = {"sha-256": 95, "sha-384": 143, "sha-512": 191}  # and the length of their text
_HEX = re.compile(r"[0-9A-Fa-f]{2}(:[0-9A-Fa-f]{2})*")
_CANDIDATE_TYPES = frozenset({"host", "srflx", "prflx", "relay"})
_SESSION_ATTRIBUTES = frozenset({"fingerprint", "ice-lite", "ice-options", "ice-pwd", "ice-ufrag", "setup"})
_CHANNELS_ATTRIBUTES = _SESSION_ATTRIBUTES - {"ice-lite"} | {"mid"}
"""`max-message-size` is not among them: messages are far below the limit of every browser."""
_MEDIA_ATTRIBUTES = _SESSION_ATTRIBUTES - {"ice-lite"} | {
    "extmap",
    "fmtp",
    "inactive",
    "mid",
    "recvonly",
    "rtcp",
    "rtcp-fb",
    "rtcp-mux",
    "rtpmap",
    "sendonly",
    "sendrecv",
}


_SSRC = re.compile(r"a=ssrc:(\d{1,10})(?: .*)?")
_REPAIRED = re.compile(r"a=ssrc-group:FID (\d{1,10}) (\d{1,10})")

Answered: TypeAlias = Direction | Literal["inactive"]
"""Direction of an application in a section."""

_LESS: Final[dict[Answered, tuple[Answered, ...]]] = {
    "recvonly": ("recvonly", "inactive"),
    "sendonly": ("sendonly", "inactive"),
    "sendrecv": ("sendrecv", "recvonly", "sendonly", "inactive"),
    "inactive": ("inactive",),
}
"""Permitted answers to an offered direction, both seen from the application."""


@dataclass(frozen=True, slots=True)
class OfferedSection:
    """Offered m-section. `direction` is that of the application, if the section is for media."""

    mid: str
    kind: str
    direction: Answered


@dataclass(frozen=True, slots=True)
class CleanAnswer:
    """Answer that aiortc can apply, without candidates, and the candidate-attributes that were in it.

    `directions` are those of the application in the sections for media, in order.
    """

    sdp: str
    candidates: tuple[str, ...]
    directions: tuple[Answered, ...]


def clean_answer(text: str, offered: Sequence[OfferedSection]) -> CleanAnswer:
    """Check an answer against the sections that were `offered` and make it safe to apply.

    Raises:
        InvalidDescription: it does not answer that offer, rejects a section, or cannot be read.
    """
    session, media = _blocks(text)
    if len(media) != len(offered):
        raise InvalidDescription(f"the answer has {len(media)} sections and must have {len(offered)}, as offered")
    for section, lines in zip(offered, media, strict=True):
        _check_media_line(lines[0], section)
    kept = [line for line in session if line[0] in "vost" or _attribute(line) in _SESSION_ATTRIBUTES]
    kept.append("a=group:BUNDLE " + " ".join(section.mid for section in offered))
    bundled = {mid for line in session if line.startswith("a=group:BUNDLE ") for mid in line.split()[1:]}
    if bundled != {section.mid for section in offered}:
        raise InvalidDescription("the answer does not bundle all sections")
    candidates: list[str] = []
    sources: list[int] = []
    for section, lines in zip(offered, media, strict=True):
        candidates += [line.removeprefix("a=") for line in lines if _attribute(line) == "candidate"][:CANDIDATES_LIMIT]
        known = _CHANNELS_ATTRIBUTES if section.kind == "application" else _MEDIA_ATTRIBUTES
        passing = [line for line in lines if line[0] in "mc" or _attribute(line) in known]
        if section.kind == "application":
            passing.append(_sctp_port(section, lines))
        if len(passing) > LINES_LIMIT:
            raise InvalidDescription(f"section {section.mid} is too long")
        kept += passing
        if section.direction in {"sendonly", "sendrecv"}:
            own = _sources(lines)
            sources += own
            kept += _source_lines(own)
    if len(set(sources)) < len(sources):
        raise InvalidDescription("the answer names a source (SSRC) twice")
    sdp = "\r\n".join(kept) + "\r\n"
    # All sections share one path, so their candidates are the same, and those beyond the limit are of no use.
    unique = tuple(dict.fromkeys(candidates))[:CANDIDATES_LIMIT]
    return CleanAnswer(sdp, unique, _check_parsed(sdp, offered))


def _blocks(text: str) -> tuple[list[str], list[list[str]]]:
    """Return the session's lines, and the lines of each m-section."""
    session: list[str] = []
    media: list[list[str]] = []
    for line in text.replace("\r\n", "\n").removesuffix("\n").split("\n"):
        if not _LINE.fullmatch(line):
            raise InvalidDescription("the answer is not SDP")
        if line.startswith("m="):
            media.append([])
        (media[-1] if media else session).append(line)
    return session, media


def _attribute(line: str) -> str:
    return line[2:].partition(":")[0] if line.startswith("a=") else ""


def mids_of(sdp: str) -> tuple[str, ...]:
    """Return the names of the sections of a description, in their order."""
    return tuple(_MID.findall(sdp))


def _sctp_port(offered: OfferedSection, lines: Sequence[str]) -> str:
    """Return the line with the SCTP port of the other end (RFC 8841 section 5)."""
    found = [line for line in lines if _SCTP_PORT.fullmatch(line)]
    if len(found) != 1 or int(found[0].partition(":")[2]) >= 2**16:
        raise InvalidDescription(f"section {offered.mid} has no usable SCTP port")
    return found[0]


def _check_media_line(line: str, offered: OfferedSection) -> None:
    found = (_CHANNELS if offered.kind == "application" else _MEDIA).fullmatch(line)
    if found is None or found[1] != offered.kind:
        raise InvalidDescription(f"section {offered.mid} is not the {offered.kind} section that was offered")
    if int(found[2]) == 0:
        raise InvalidDescription(f"the {offered.kind} section {offered.mid} was rejected")


def _sources(lines: Sequence[str]) -> list[int]:
    """Return the SSRC of a section and that of its retransmissions (RFC 5576, RFC 4588), if it names them."""
    named = [found for line in lines if (found := _SSRC.fullmatch(line))]
    groups = [found for line in lines if (found := _REPAIRED.fullmatch(line))]
    numbers = [int(number) for found in (groups or named)[:1] for number in found.groups()]
    if not all(0 < number < 2**32 for number in numbers):
        raise InvalidDescription("the answer names a source (SSRC) out of range")
    return numbers


def _source_lines(sources: Sequence[int]) -> list[str]:
    """Return the lines of `sources` for aiortc: the first is the media, a second one its retransmissions."""
    group = [f"a=ssrc-group:FID {sources[0]} {sources[1]}"] if len(sources) > 1 else []
    return group + [f"a=ssrc:{number} cname:application" for number in sources]


def _check_parsed(sdp: str, offered: Sequence[OfferedSection]) -> tuple[Answered, ...]:
    """Check the SDP as aiortc parses it, and return the application's direction in each section.

    A fault missed here would fail later, in a task of its own or half-way through.
    """
    directions: list[Answered] = []
    try:
        parsed = SessionDescription.parse(sdp)
    except Exception as error:  # its parser raises anything on hostile text
        raise InvalidDescription("the answer cannot be parsed") from error
    for section, media in zip(offered, parsed.media, strict=True):
        if media.rtp.muxId != section.mid:
            raise InvalidDescription(f"the answer has another section in the place of {section.mid}")
        if media.ice is None or not _are_credentials(media.ice.usernameFragment, media.ice.password):
            raise InvalidDescription(f"section {section.mid} has no valid ICE credentials")
        if media.dtls is None or media.dtls.role == "auto" or not _are_fingerprints(media.dtls.fingerprints):
            raise InvalidDescription(f"section {section.mid} has no usable DTLS fingerprint or role")
        if section.kind != "application":
            directions.append(_check_media(section, media))
    return tuple(directions)


def _check_media(section: OfferedSection, media: MediaDescription) -> Answered:
    """Check a section for media, and return the application's direction in it."""
    found = [answered for answered in _LESS[section.direction] if answered == media.direction]
    if not found:
        raise InvalidDescription(f"section {section.mid} cannot be {media.direction}")
    if not media.rtp.codecs:
        raise InvalidDescription(f"section {section.mid} has no codec")
    if not all(codec.payloadType in _PAYLOAD_TYPES for codec in media.rtp.codecs):
        raise InvalidDescription(f"section {section.mid} has a payload type that cannot be sent")
    if not all(extension.id in _EXTENSION_IDS for extension in media.rtp.headerExtensions):
        raise InvalidDescription(f"section {section.mid} has a header extension id that cannot be sent")
    return found[0]


def _are_fingerprints(found: Sequence[RTCDtlsFingerprint]) -> bool:
    """Tell whether at least one has a hash that certificates are still checked with (RFC 8122 section 5)."""
    known = [each for each in found if each.algorithm.lower() in _HASHES]
    return any(_HEX.fullmatch(each.value) and len(each.value) == _HASHES[each.algorithm.lower()] for each in known)


def _are_credentials(fragment: str | None, password: str | None) -> bool:
    return _UFRAG.fullmatch(fragment or "") is not None and _PASSWORD.fullmatch(password or "") is not None


def read_candidate(text: str, mid: str, policy: CandidatePolicy) -> RTCIceCandidate | None:
    """Read a candidate-attribute (RFC 8839 section 5.1), with or without `a=`, as a candidate of the section `mid`.

    Returns:
        None if it cannot be used: TCP, another component than RTP, a name instead of an address, or an address or port
        that `policy` does not permit.

    Raises:
        InvalidCandidate: it is malformed.
    """
    attribute = text.removeprefix("a=").removeprefix("candidate:")
    try:
        candidate = candidate_from_sdp(attribute)
    except Exception as error:  # its parser raises anything on hostile text
        raise InvalidCandidate("the candidate cannot be parsed") from error
    if not (0 <= candidate.port < 2**16 and 0 <= candidate.priority < 2**32) or candidate.type not in _CANDIDATE_TYPES:
        raise InvalidCandidate("the candidate has a value out of range")
    usable = candidate.component == 1 and candidate.protocol.lower() == "udp"
    if not usable or not policy.permits_target(candidate.ip, candidate.port):
        return None
    candidate.sdpMid = mid
    return candidate
