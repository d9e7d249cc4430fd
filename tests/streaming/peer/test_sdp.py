import contextlib
from typing import Any

import aiortc.sdp
import pytest
from aiortc.sdp import SessionDescription
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_signaling.messages import CANDIDATES_LIMIT
from openrois_streaming.errors import InvalidCandidate, InvalidDescription
from openrois_streaming.network.policy import CandidatePolicy
from openrois_streaming.peer import sdp
from openrois_streaming.peer.sdp import Answered, OfferedSection, clean_answer, read_candidate

from tests.support.answers import CANDIDATES, answer, channels, section, video_and_audio
from tests.support.steps import lines_run

VIDEO, AUDIO = OfferedSection("0", "video", "recvonly"), OfferedSection("1", "audio", "recvonly")
POLICY = CandidatePolicy()


def test_a_browsers_answer_passes_without_its_candidates() -> None:
    clean = clean_answer(video_and_audio(), [VIDEO, AUDIO])
    assert clean.candidates == CANDIDATES
    assert "candidate" not in clean.sdp
    assert "rtcp-rsize" not in clean.sdp
    parsed = SessionDescription.parse(clean.sdp)
    assert [(media.kind, media.rtp.muxId, media.direction) for media in parsed.media] == [
        ("video", "0", "recvonly"),
        ("audio", "1", "recvonly"),
    ]
    assert [codec.mimeType for codec in parsed.media[0].rtp.codecs] == ["video/VP8", "video/rtx"]
    assert [str(group) for group in parsed.group] == ["BUNDLE 0 1"]


def test_the_bundle_is_put_in_the_order_of_the_offer() -> None:
    clean = clean_answer(video_and_audio().replace("BUNDLE 0 1", "BUNDLE 1 0"), [VIDEO, AUDIO])
    assert "a=group:BUNDLE 0 1\r\n" in clean.sdp


def test_an_idle_section_is_answered_inactive() -> None:
    idle = OfferedSection("0", "video", "inactive")
    clean = clean_answer(answer(section("0", "video", "inactive"), bundle="0"), [idle])
    assert "a=inactive\r\n" in clean.sdp


@pytest.mark.parametrize(
    ("offered", "less", "more"),
    [
        ("recvonly", {"recvonly", "inactive"}, {"sendonly", "sendrecv"}),
        ("sendonly", {"sendonly", "inactive"}, {"recvonly", "sendrecv"}),
        ("sendrecv", {"sendrecv", "sendonly", "recvonly", "inactive"}, set()),
        ("inactive", {"inactive"}, {"sendonly", "recvonly", "sendrecv"}),
    ],
)
def test_an_application_may_do_less_than_was_offered_and_never_more(
    offered: Answered, less: set[str], more: set[str]
) -> None:
    section_of = OfferedSection("1", "audio", offered)
    for direction in less:
        clean = clean_answer(answer(section("1", "audio", direction), bundle="1"), [section_of])
        assert clean.directions == (direction,)
    for direction in more:
        with pytest.raises(InvalidDescription, match=f"cannot be {direction}"):
            clean_answer(answer(section("1", "audio", direction), bundle="1"), [section_of])


CAMERA = OfferedSection("0", "video", "sendonly")
SENT = ["a=ssrc-group:FID 11 12", "a=ssrc:11 cname:x y", "a=ssrc:11 msid:- t", "a=ssrc:12 cname:x", "a=msid:- t"]


@pytest.mark.parametrize(
    ("extra", "found"),
    [
        (SENT, [11, 12]),
        (SENT[1:2], [11]),
        (SENT[1:], [11]),
        (["a=ssrc-group:SIM 1 2 3", *SENT], [11, 12]),
        ([*reversed(SENT)], [11, 12]),
        (["a=ssrc:11"], [11]),
        ([], []),
    ],
)
def test_answer_of_a_sender_names_its_sources(extra: list[str], found: list[int]) -> None:
    clean = clean_answer(answer(section("0", "video", "sendonly", extra=extra), bundle="0"), [CAMERA])
    media = SessionDescription.parse(clean.sdp).media[0]
    assert [each.ssrc for each in media.ssrc] == found
    assert "msid" not in clean.sdp
    if len(found) == 2:
        assert [(group.semantic, group.items) for group in media.ssrc_group] == [("FID", found)]


def test_sources_of_a_receiver_are_removed() -> None:
    clean = clean_answer(answer(section("0", "video", extra=SENT), bundle="0"), [VIDEO])
    assert "ssrc" not in clean.sdp


@pytest.mark.parametrize("number", ["0", "4294967296"])
def test_a_source_is_a_number_of_32_bits(number: str) -> None:
    lines = section("0", "video", "sendonly", extra=[f"a=ssrc:{number} cname:x"])
    with pytest.raises(InvalidDescription, match="out of range"):
        clean_answer(answer(lines, bundle="0"), [CAMERA])


def test_no_two_sections_have_the_same_source() -> None:
    sections = [section(mid, "video", "sendonly", extra=["a=ssrc:7 cname:x"]) for mid in "01"]
    offered = [CAMERA, OfferedSection("1", "video", "sendonly")]
    with pytest.raises(InvalidDescription, match="twice"):
        clean_answer(answer(*sections, bundle="0 1"), offered)


def test_candidates_are_as_many_as_one_path_needs() -> None:
    many = [f"a=candidate:1 1 udp 1 192.0.2.17 {port} typ host" for port in range(2000, 2000 + 2 * CANDIDATES_LIMIT)]
    lines = section("0", "video", extra=[many[0], *many])
    assert clean_answer(answer(lines, bundle="0"), [VIDEO]).candidates == tuple(
        line.removeprefix("a=") for line in many[: CANDIDATES_LIMIT - 1]
    )


def test_a_rejected_section_is_named() -> None:
    text = answer(section("0", "video", port=0), section("1", "audio"), bundle="0 1")
    with pytest.raises(InvalidDescription, match="the video section 0 was rejected"):
        clean_answer(text, [VIDEO, AUDIO])


LONG = [f"a=rtpmap:{number} x/90000" for number in range(200)]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "not SDP"),
        ("\x00", "not SDP"),
        ("v=0\r\nnonsense\r\n", "not SDP"),
        (video_and_audio().replace("a=mid:0", "a=mid:0\x1b[2J"), "not SDP"),
        (video_and_audio().replace("a=mid:0", "a=mid:é"), "not SDP"),
        (answer(section("0", "video"), bundle="0"), "1 sections and must have 2"),
        (answer(*[section(str(number), "video") for number in range(3)], bundle="0 1 2"), "3 sections and must have 2"),
        (video_and_audio().replace("a=group:BUNDLE 0 1\r\n", ""), "does not bundle"),
        (video_and_audio().replace("BUNDLE 0 1", "BUNDLE 0"), "does not bundle"),
        (answer(section("1", "audio"), section("0", "video"), bundle="0 1"), "not the video section"),
        (answer(section("1", "video"), section("0", "audio"), bundle="0 1"), "another section in the place of 0"),
        (video_and_audio().replace("m=audio 9 ", "m=audio 9/2 "), "not the audio section"),
        (video_and_audio().replace("a=recvonly", "a=sendrecv"), "cannot be sendrecv"),
        (video_and_audio().replace("a=recvonly", "a=sendonly"), "cannot be sendonly"),
        (video_and_audio().replace("a=recvonly\r\n", ""), "cannot be None"),
        (video_and_audio().replace("a=ice-ufrag:aBcD\r\n", ""), "ICE credentials"),
        (video_and_audio().replace("a=ice-ufrag:aBcD\r\n", "a=ice-ufrag:" + "a" * 300 + "\r\n"), "ICE credentials"),
        (video_and_audio().replace("a=ice-pwd:0123456789", "a=ice-pwd:short"), "ICE credentials"),
        (video_and_audio().replace("a=setup:active\r\n", ""), "DTLS fingerprint or role"),
        (video_and_audio().replace("a=setup:active", "a=setup:actpass"), "DTLS fingerprint or role"),
        (video_and_audio().replace("a=fingerprint:", "a=finger:"), "DTLS fingerprint or role"),
        (video_and_audio().replace("sha-256", "sha-1"), "DTLS fingerprint or role"),
        (video_and_audio().replace("AB:AB", "AB"), "DTLS fingerprint or role"),
        (video_and_audio().replace("AB:AB", "AB:XX"), "DTLS fingerprint or role"),
        (video_and_audio().replace("a=setup:active", "a=setup:nonsense"), "cannot be parsed"),
        (video_and_audio().replace("a=fmtp:98 apt=97", "a=fmtp:99 apt=97"), "cannot be parsed"),
        (video_and_audio().replace("a=rtpmap:97 VP8/90000", "a=rtpmap:97 VP8"), "cannot be parsed"),
        (video_and_audio().replace("m=video 9 UDP/TLS/RTP/SAVPF 97", "m=video 9 UDP/TLS/RTP/SAVPF 999"), "parsed"),
        (video_and_audio().replace("97 98", "97 200").replace(":98 ", ":200 "), "payload type"),
        (video_and_audio().replace("97 98", "97 70").replace(":98 ", ":70 "), "payload type"),
        (video_and_audio().replace("a=extmap:1 ", "a=extmap:15 "), "header extension"),
        (answer(section("0", "video", extra=LONG), section("1", "audio"), bundle="0 1"), "section 0 is too long"),
    ],
)
def test_unusable_answer_is_refused_with_reason(text: str, reason: str) -> None:
    with pytest.raises(InvalidDescription, match=reason):
        clean_answer(text, [VIDEO, AUDIO])


def test_a_section_needs_a_codec() -> None:
    lines = [line for line in section("1", "audio") if not line.startswith(("a=rtpmap", "a=fmtp"))]
    with pytest.raises(InvalidDescription, match="no codec"):
        clean_answer(answer(lines, bundle="1"), [AUDIO])


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_hostile_answers_raise_nothing_else(data: st.DataObject) -> None:
    sent = answer(section("0", "video", "sendonly", extra=SENT), section("1", "audio"), bundle="0 1")
    text = data.draw(st.sampled_from([video_and_audio(), sent]))
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(text)))
        end = data.draw(st.integers(start, min(len(text), start + 30)))
        junk = data.draw(st.text(max_size=4) | st.sampled_from(["a=", "m=video 9 UDP 0", "\r\n", ":", " ", "0", "-1"]))
        text = text[:start] + junk + text[end:]
    try:
        clean = clean_answer(text, [data.draw(st.sampled_from([VIDEO, CAMERA])), AUDIO])
    except InvalidDescription:
        return
    assert len(SessionDescription.parse(clean.sdp).media) == 2


def test_the_largest_answer_takes_little_work() -> None:
    filler = ["a=rtcp-fb:* nack pli", "a=rtpmap:99 VP8/90000"] * 50 + ["a=ssrc:7 msid:x"] * 50
    sections = [section(str(mid), "video", extra=filler) for mid in range(16)]
    offered = [OfferedSection(str(mid), "video", "recvonly") for mid in range(16)]
    text = answer(*sections, bundle=" ".join(map(str, range(16))))
    assert len(text) > 48 * 1024
    assert lines_run(lambda: clean_answer(text, offered), sdp, aiortc.sdp) < 20 * len(text)


def test_a_candidate_is_read_with_and_without_its_prefixes() -> None:
    bare = CANDIDATES[0].removeprefix("candidate:")
    for text in (bare, CANDIDATES[0], f"a={CANDIDATES[0]}"):
        candidate = read_candidate(text, "0", POLICY)
        assert candidate is not None
        assert (candidate.ip, candidate.port, candidate.type, candidate.sdpMid) == ("192.0.2.17", 50000, "host", "0")


@pytest.mark.parametrize(
    "text",
    [
        CANDIDATES[1],
        "candidate:1 1 tcp 1518280447 192.0.2.17 9 typ host tcptype active",
        "candidate:1 2 udp 1 192.0.2.17 50000 typ host",
        "candidate:1 1 udp 1 192.0.2.17 0 typ host",
        "candidate:1 1 udp 1 192.0.2.17 53 typ host",
        "candidate:1 1 udp 1 example.org 50000 typ host",
        "candidate:1 1 udp 1 2130706433 50000 typ host",
        "candidate:1 1 udp 1 0177.0.0.1 50000 typ host",
    ],
)
def test_useless_candidates_are_ignored_and_no_name_is_resolved(text: str) -> None:
    assert read_candidate(text, "0", POLICY) is None


@pytest.mark.parametrize(
    "text",
    [
        "",
        "candidate:",
        "candidate:1 1 udp 1 192.0.2.17 50000 typ",
        "candidate:1 one udp 1 192.0.2.17 50000 typ host",
        "candidate:1 1 udp 1 192.0.2.17 70000 typ host",
        "candidate:1 1 udp 1 192.0.2.17 -5 typ host",
        "candidate:1 1 udp 99999999999 192.0.2.17 50000 typ host",
        "candidate:1 1 udp 1 192.0.2.17 50000 typ guess",
        "candidate:1 1 udp 1 192.0.2.17 50000 typ host rport none",
    ],
)
def test_a_candidate_that_cannot_be_read_is_refused(text: str) -> None:
    with pytest.raises(InvalidCandidate):
        read_candidate(text, "0", POLICY)


@settings(max_examples=100)
@given(st.lists(st.text(max_size=8) | st.sampled_from(CANDIDATES[0].split()), max_size=14))
def test_hostile_candidates_raise_nothing_else(words: list[str]) -> None:
    with contextlib.suppress(InvalidCandidate):
        read_candidate(" ".join(words), "0", POLICY)


CHANNELS = OfferedSection("1", "application", "inactive")


def with_channels(**bent: Any) -> str:
    return answer(section("0", "video"), channels("1", **bent), section("2", "audio"), bundle="0 1 2")


def test_data_channels_are_answered_between_media() -> None:
    clean = clean_answer(with_channels(), [VIDEO, CHANNELS, OfferedSection("2", "audio", "recvonly")])
    assert clean.directions == ("recvonly", "recvonly")
    assert "max-message-size" not in clean.sdp
    parsed = SessionDescription.parse(clean.sdp)
    assert [(media.kind, media.sctp_port) for media in parsed.media] == [
        ("video", None),
        ("application", 5000),
        ("audio", None),
    ]


@pytest.mark.parametrize(
    ("bent", "told"),
    [
        ({"port": 0}, "rejected"),
        ({"lines": ()}, "SCTP port"),
        ({"lines": ("a=sctp-port:0",)}, "SCTP port"),
        ({"lines": ("a=sctp-port:65536",)}, "SCTP port"),
        ({"lines": ("a=sctp-port:5000", "a=sctp-port:5001")}, "SCTP port"),
    ],
)
def test_data_channels_that_cannot_be_used(bent: dict[str, Any], told: str) -> None:
    with pytest.raises(InvalidDescription, match=told):
        clean_answer(with_channels(**bent), [VIDEO, CHANNELS, OfferedSection("2", "audio", "recvonly")])


def test_media_is_not_answered_with_data_channels() -> None:
    with pytest.raises(InvalidDescription, match="video section"):
        clean_answer(answer(channels("0"), bundle="0"), [VIDEO])
    with pytest.raises(InvalidDescription, match="application section"):
        clean_answer(answer(section("1", "video"), bundle="1"), [CHANNELS])


def test_the_names_of_sections() -> None:
    assert sdp.mids_of(with_channels()) == ("0", "1", "2")
