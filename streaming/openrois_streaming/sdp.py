"""What an application says in SDP, cleaned before aiortc sees it.

aiortc's parser meets hostile text with any exception, it applies an answer section by section, and it keeps only the
last section's candidates of a bundle. So an answer is taken apart here: only attributes that matter pass, sections must
be the offered ones in the offered order, and candidates come out of it, to be added one by one.
"""

import ipaddress
import re
from collections.abc import Sequence
from dataclasses import dataclass

from aiortc import RTCIceCandidate
from aiortc.sdp import SessionDescription, candidate_from_sdp

from openrois_streaming.errors import InvalidCandidate, InvalidDescription

LINES_LIMIT = 128
"""Lines of one section that pass; aiortc's parser takes a time that grows with their square. Chromium has 40."""

_LINE = re.compile(r"[a-z]=[ -~]*")
_MEDIA = re.compile(r"m=(audio|video) (\d{1,5}) [A-Z/]{1,32}( \d{1,3}){1,32}")
_UFRAG = re.compile(r"[A-Za-z0-9+/]{4,256}")  # RFC 8839 section 5.4
_PASSWORD = re.compile(r"[A-Za-z0-9+/]{22,256}")
_EXTENSION_IDS = range(1, 15)  # of the one-byte form, RFC 8285 section 4.2
_CANDIDATE_TYPES = frozenset({"host", "srflx", "prflx", "relay"})
_SESSION_ATTRIBUTES = frozenset({"fingerprint", "ice-lite", "ice-options", "ice-pwd", "ice-ufrag", "setup"})
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


@dataclass(frozen=True, slots=True)
class OfferedSection:
    """An m-section as it was offered. `active` is whether it carries a stream."""

    mid: str
    kind: str
    active: bool


@dataclass(frozen=True, slots=True)
class CleanAnswer:
    """An answer that can be given to aiortc, without candidates, and the candidate-attributes that were in it."""

    sdp: str
    candidates: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class CandidatePolicy:
    """Which addresses of viewers a deployment sends to. Multicast and unspecified addresses are never used.

    `allow_private` covers the private networks of RFC 1918 and RFC 4193, and shared address space (RFC 6598).
    """

    allow_loopback: bool = True
    allow_private: bool = True
    allow_link_local: bool = False

    def permits(self, host: str) -> bool:
        """Whether `host` is a literal IP address that may be used; names, `.local` above all, are never resolved."""
        try:
            address = ipaddress.ip_address(host)
        except ValueError:
            return False
        if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is not None:
            address = address.ipv4_mapped
        if address.is_multicast or address.is_unspecified:
            return False
        if address.is_loopback:
            return self.allow_loopback
        if address.is_link_local:
            return self.allow_link_local
        return address.is_global or self.allow_private


def clean_answer(text: str, offered: Sequence[OfferedSection]) -> CleanAnswer:
    """Check an answer against the sections that were `offered` and make it safe to apply.

    Raises:
        InvalidDescription: it does not answer that offer, rejects a section, or cannot be read.
    """
    session, media = _blocks(text)
    if len(media) != len(offered):
        raise InvalidDescription(f"the answer has {len(media)} sections where {len(offered)} were offered")
    for section, lines in zip(offered, media, strict=True):
        _check_media_line(lines[0], section)
    kept = [line for line in session if line[0] in "vost" or _attribute(line) in _SESSION_ATTRIBUTES]
    kept.append("a=group:BUNDLE " + " ".join(section.mid for section in offered))
    bundled = {mid for line in session if line.startswith("a=group:BUNDLE ") for mid in line.split()[1:]}
    if bundled != {section.mid for section in offered}:
        raise InvalidDescription("the answer does not bundle all sections")
    candidates: list[str] = []
    for section, lines in zip(offered, media, strict=True):
        candidates += [line.removeprefix("a=") for line in lines if _attribute(line) == "candidate"]
        passing = [line for line in lines if line[0] in "mc" or _attribute(line) in _MEDIA_ATTRIBUTES]
        if len(passing) > LINES_LIMIT:
            raise InvalidDescription(f"section {section.mid} is too long")
        kept += passing
    sdp = "\r\n".join(kept) + "\r\n"
    _check_parsed(sdp, offered)
    return CleanAnswer(sdp, tuple(candidates))


def _blocks(text: str) -> tuple[list[str], list[list[str]]]:
    """The session's lines, and the lines of each m-section."""
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


def _check_media_line(line: str, offered: OfferedSection) -> None:
    found = _MEDIA.fullmatch(line)
    if found is None or found[1] != offered.kind:
        raise InvalidDescription(f"section {offered.mid} is not the {offered.kind} section that was offered")
    if int(found[2]) == 0:
        raise InvalidDescription(f"the {offered.kind} section {offered.mid} was rejected")


def _check_parsed(sdp: str, offered: Sequence[OfferedSection]) -> None:
    """Check what aiortc reads in it. What it misses here would fail later, in a task of its own or half-way through."""
    try:
        parsed = SessionDescription.parse(sdp)
    except Exception as error:  # its parser raises whatever hostile text makes of it
        raise InvalidDescription("the answer cannot be parsed") from error
    for section, media in zip(offered, parsed.media, strict=True):
        if media.rtp.muxId != section.mid:
            raise InvalidDescription(f"the answer has another section in the place of {section.mid}")
        if media.direction != ("recvonly" if section.active else "inactive"):
            raise InvalidDescription(f"section {section.mid} cannot be {media.direction}")
        if media.ice is None or not _are_credentials(media.ice.usernameFragment, media.ice.password):
            raise InvalidDescription(f"section {section.mid} has no valid ICE credentials")
        if media.dtls is None or not media.dtls.fingerprints or media.dtls.role == "auto":
            raise InvalidDescription(f"section {section.mid} has no DTLS fingerprint or role")
        if not media.rtp.codecs:
            raise InvalidDescription(f"section {section.mid} has no codec")
        if not all(extension.id in _EXTENSION_IDS for extension in media.rtp.headerExtensions):
            raise InvalidDescription(f"section {section.mid} has a header extension id that cannot be sent")


def _are_credentials(fragment: str | None, password: str | None) -> bool:
    return _UFRAG.fullmatch(fragment or "") is not None and _PASSWORD.fullmatch(password or "") is not None


def read_candidate(text: str, mid: str, policy: CandidatePolicy) -> RTCIceCandidate | None:
    """A candidate-attribute (RFC 8839 section 5.1), with or without `a=`, as a candidate of the section `mid`.

    Returns:
        None if it is of no use here: TCP, another component than RTP, port 0, a name instead of an address, or an
        address that `policy` does not permit.

    Raises:
        InvalidCandidate: it cannot be read.
    """
    attribute = text.removeprefix("a=").removeprefix("candidate:")
    try:
        candidate = candidate_from_sdp(attribute)
    except Exception as error:  # its parser raises whatever hostile text makes of it
        raise InvalidCandidate("the candidate cannot be parsed") from error
    if not (0 <= candidate.port < 2**16 and 0 <= candidate.priority < 2**32) or candidate.type not in _CANDIDATE_TYPES:
        raise InvalidCandidate("the candidate has a value out of range")
    usable = candidate.component == 1 and candidate.protocol.lower() == "udp" and candidate.port != 0
    if not usable or not policy.permits(candidate.ip):
        return None
    candidate.sdpMid = mid
    return candidate
