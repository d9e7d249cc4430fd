"""Answers as browsers write them, to be bent by tests."""

from collections.abc import Sequence

CANDIDATES = (
    "candidate:1 1 udp 2113937151 192.0.2.17 50000 typ host generation 0 ufrag aBcD network-cost 999",
    "candidate:2 1 udp 2113939711 5ac3ecd5-4f6b-4f3d-9c2f-1d3e5b7a9c01.local 50001 typ host generation 0",
)

_CODECS = {
    "video": (
        "97 98",
        "a=rtpmap:97 VP8/90000",
        "a=rtcp-fb:97 goog-remb",
        "a=rtcp-fb:97 nack pli",
        "a=rtpmap:98 rtx/90000",
        "a=fmtp:98 apt=97",
    ),
    "audio": ("96", "a=rtpmap:96 opus/48000/2", "a=fmtp:96 minptime=10;useinbandfec=1"),
}


def section(mid: str, kind: str, direction: str = "recvonly", *, port: int = 9, extra: Sequence[str] = ()) -> list[str]:
    """The lines of one m-section."""
    payload_types, *codecs = _CODECS[kind]
    return [
        f"m={kind} {port} UDP/TLS/RTP/SAVPF {payload_types}",
        "c=IN IP4 0.0.0.0",
        "a=rtcp:9 IN IP4 0.0.0.0",
        *extra,
        "a=ice-ufrag:aBcD",
        "a=ice-pwd:0123456789abcdefghijklmn",
        "a=ice-options:trickle",
        "a=fingerprint:sha-256 " + ":".join(["AB"] * 32),
        "a=setup:active",
        f"a=mid:{mid}",
        "a=extmap:1 urn:ietf:params:rtp-hdrext:sdes:mid",
        f"a={direction}",
        "a=rtcp-mux",
        "a=rtcp-rsize",
        *codecs,
    ]


SCTP = ("a=sctp-port:5000", "a=max-message-size:262144")


def channels(mid: str, *, port: int = 9, lines: Sequence[str] = SCTP) -> list[str]:
    """The lines of a section for data channels, as Chromium answers it."""
    return [
        f"m=application {port} UDP/DTLS/SCTP webrtc-datachannel",
        "c=IN IP4 0.0.0.0",
        "a=ice-ufrag:aBcD",
        "a=ice-pwd:0123456789abcdefghijklmn",
        "a=ice-options:trickle",
        "a=fingerprint:sha-256 " + ":".join(["AB"] * 32),
        "a=setup:active",
        f"a=mid:{mid}",
        *lines,
    ]


def answer(*sections: Sequence[str], bundle: str) -> str:
    """A whole answer."""
    head = ["v=0", "o=- 4611731400430051336 2 IN IP4 127.0.0.1", "s=-", "t=0 0", f"a=group:BUNDLE {bundle}"]
    lines = [*head, "a=msid-semantic: WMS", *(line for each in sections for line in each)]
    return "\r\n".join(lines) + "\r\n"


def video_and_audio() -> str:
    """What Chromium answers to a video section "0" and an audio section "1": all candidates in the first."""
    first = section("0", "video", extra=[f"a={each}" for each in CANDIDATES])
    return answer([*first, "a=end-of-candidates"], section("1", "audio"), bundle="0 1")
