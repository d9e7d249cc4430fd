"""What is read in descriptions of game engines and applications, and what an application may answer."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_avatar.facades.sections import (
    CandidateLine,
    Section,
    UnusableDescription,
    check_answer,
    section_for,
    sections_of,
    split_candidates,
)

from tests.support.facade_session import CHANNEL, media, sdp

OFFER = sdp(media("video", "0"), media("audio", "1", "sendrecv"), CHANNEL)


def test_the_sections_of_a_description_are_known_by_kind_name_and_way() -> None:
    assert sections_of(OFFER) == (
        Section("video", "0", "sendonly", rejected=False),
        Section("audio", "1", "sendrecv", rejected=False),
        Section("application", "2", "sendrecv", rejected=False),
    )


def test_a_way_of_the_session_is_one_of_its_sections() -> None:
    assert sections_of(sdp(media("audio", "a", ""), session="a=recvonly\r\n"))[0].way == "recvonly"


def test_port_0_is_a_rejected_section_unless_it_is_bundled() -> None:
    assert sections_of(sdp(media("audio", "a", port=0)))[0].rejected
    assert not sections_of(sdp(media("audio", "a", port=0, more="a=bundle-only\r\n")))[0].rejected


def test_the_first_section_that_sends_is_the_picture() -> None:
    offered = sections_of(sdp(media("video", "a", "recvonly"), media("video", "b"), media("video", "c")))
    assert section_for("video", offered) == offered[1]
    assert section_for("audio", offered) is None


@pytest.mark.parametrize(
    "text",
    [
        "",
        "hello",
        sdp(),
        sdp(*(media("video", str(mid)) for mid in range(17))),
        sdp(media("video", "0"), media("audio", "0")),
        sdp("m=video\r\na=mid:0\r\n"),
        sdp("m=video 9 RTP 96\r\n"),
        sdp(media("video", "0", more="a=mid:1\r\n")),
        sdp(media("video", "x" * 65)),
        sdp(media("video", "0", more="a=\x00\r\n")),
    ],
)
def test_malformed_description_is_refused(text: str) -> None:
    with pytest.raises(UnusableDescription):
        sections_of(text)


ANSWER = (media("video", "0", "recvonly"), media("audio", "1", "recvonly"))
IDLE_CHANNEL = "m=application 0 UDP/DTLS/SCTP webrtc-datachannel\r\na=mid:2\r\n"


def test_an_answer_takes_what_is_connected() -> None:
    offered = sections_of(OFFER)
    check_answer(sdp(*ANSWER, IDLE_CHANNEL), offered, {"0", "1"})
    check_answer(sdp(ANSWER[0], media("audio", "1", "inactive"), IDLE_CHANNEL), offered, {"0"})
    check_answer(sdp(ANSWER[0], media("audio", "1", "recvonly", 0), IDLE_CHANNEL), offered, {"0"})


@pytest.mark.parametrize(
    ("sections", "connected", "why"),
    [
        (ANSWER, {"0", "1"}, "other sections"),
        ((*reversed(ANSWER), IDLE_CHANNEL), {"0", "1"}, "other sections"),
        ((*ANSWER, IDLE_CHANNEL), {"0"}, "section 1 was not connected"),
        ((*ANSWER, CHANNEL), {"0", "1"}, "section 2 was not connected"),
        (
            (ANSWER[0], media("audio", "1", "sendrecv"), IDLE_CHANNEL),
            {"0", "1"},
            "section 1 is connected: it must be answered recvonly",
        ),
        (
            (media("video", "0", "recvonly", 0), ANSWER[1], IDLE_CHANNEL),
            {"0", "1"},
            "section 0 is connected: it must be answered recvonly",
        ),
    ],
)
def test_an_answer_that_takes_or_sends_something_else_is_refused(
    sections: tuple[str, ...], connected: set[str], why: str
) -> None:
    with pytest.raises(UnusableDescription, match=why):
        check_answer(sdp(*sections), sections_of(OFFER), connected)


def test_candidates_are_taken_out_and_nothing_else_is_changed() -> None:
    line = "a=candidate:1 1 udp 1 127.0.0.1 9 typ host\r\n"
    clean, found = split_candidates(sdp(media("video", "v"), media("audio", "s", more=line)))
    assert clean == sdp(media("video", "v"), media("audio", "s"))
    assert found == (CandidateLine("candidate:1 1 udp 1 127.0.0.1 9 typ host", "s", 1),)


@given(st.lists(st.sampled_from([*OFFER.split("\r\n"), "m=", "a=mid:", "a=mid:0", "\x00", "é", "m=video 9 a b"])))
def test_any_text_is_read_or_refused(lines: list[str]) -> None:
    text = "\n".join(lines)
    try:
        found = sections_of(text)
    except UnusableDescription:
        return
    assert split_candidates(text)[0] == text
    assert all(section.mid for section in found)
