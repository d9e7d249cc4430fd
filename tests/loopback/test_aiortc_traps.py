"""Where aiortc behaves otherwise than one expects; each test is named after the trap that it keeps us out of."""

import pytest
from openrois_signaling.messages import IceServer, Offer
from openrois_streaming.errors import InvalidDescription, UnexpectedAnswer
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.send.sender import Negotiated, RtpSender, Wire
from openrois_streaming.state import StreamStatus

from tests.support import loopback
from tests.support.loopback import Engine, Viewer, only_first_section, sections, without

pytestmark = pytest.mark.media


async def test_trap_1_a_later_section_shares_the_transport_of_the_first(engine: Engine, viewer: Viewer) -> None:
    engine.connect("v", "video")
    await viewer.plays("0")
    states = list(viewer.states)
    engine.connect("a", "audio")
    await viewer.plays("1")
    await viewer.plays("0")
    assert viewer.states == states == ["connecting", "connected"]
    (connection,) = viewer.connections.values()
    assert len({each.sender.transport for each in connection.getTransceivers()}) == 1


async def test_trap_2_candidates_of_the_first_of_two_sections_are_enough(engine: Engine, viewer: Viewer) -> None:
    viewer.bend_offer = no_candidates
    viewer.bend_answer = lambda sdp: only_first_section(sdp, "a=candidate")
    engine.connect("v", "video")
    engine.connect("a", "audio")
    await viewer.plays("0")
    await viewer.plays("1")
    (connection,) = viewer.connections.values()
    ice = connection.getTransceivers()[0].sender.transport.transport
    assert {candidate.type for candidate in ice.getRemoteCandidates()} == {"prflx"}


async def test_trap_2_trickled_candidates_may_name_any_section(engine: Engine, viewer: Viewer) -> None:
    withheld: list[str] = []

    def withhold(sdp: str) -> str:
        withheld.extend(line[2:] for line in sdp.splitlines() if line.startswith("a=candidate"))
        return no_candidates(sdp)

    viewer.bend_offer = no_candidates
    viewer.bend_answer = withhold
    engine.connect("v", "video")
    engine.connect("a", "audio")
    await engine.news.until(lambda: withheld)
    for candidate in withheld:
        await engine.candidate(engine.offers[0], candidate, "1")
    await viewer.plays("0")


async def test_trap_3_a_rejected_section_ends_that_peer_only(engine: Engine, viewer: Viewer) -> None:
    async with loopback.engine() as other_engine, loopback.viewer(other_engine) as other:
        other_engine.connect("v", "video")
        await other.plays()
        viewer.bend_answer = lambda sdp: _rejecting(sdp, 1)
        engine.connect("v", "video")
        engine.connect("a", "audio")
        await engine.news.until(lambda: viewer.refusals)
        assert isinstance(viewer.refusals[0], InvalidDescription)
        assert [bye.reason for bye in engine.byes] == ["the audio section 1 was rejected"]
        await engine.until("v", StreamStatus.NOT_CONNECTED)
        assert engine.session.stream_ids == engine.session.peer_ids == ()
        viewer.bend_answer = str
        engine.connect("w", "video")
        await viewer.plays("0")
        assert engine.offers[-1].peer_id == "engine/p2"
        await other.plays()


def no_candidates(sdp: str) -> str:
    return without(sdp, "a=candidate", "a=end-of-candidates")


def _rejecting(sdp: str, index: int) -> str:
    section = sections(sdp)[index]
    kind, _, rest = section.removeprefix("m=").split(" ", 2)
    return sdp.replace(section, f"m={kind} 0 {rest}")


async def test_trap_4_a_section_is_never_stopped_but_idle_and_used_again(engine: Engine, viewer: Viewer) -> None:
    engine.connect("v", "video")
    engine.connect("a", "audio")
    await viewer.plays("0")
    engine.session.disconnect("v")
    await engine.news.until(lambda: len(engine.offers) == 2)
    assert ["a=inactive" in section for section in sections(engine.offers[1].sdp)] == [True, False]
    assert [listed.stream_id for listed in engine.offers[1].streams] == ["a"]
    await viewer.plays("1", 10)
    engine.connect("w", "video")
    await viewer.plays("0")
    assert [(listed.mid, listed.stream_id) for listed in engine.offers[-1].streams] == [("0", "w"), ("1", "a")]
    assert all("a=sendonly" in section for section in sections(engine.offers[-1].sdp))
    assert "m=video 0" not in engine.offers[-1].sdp


async def test_trap_5_a_sender_survives_the_failure_of_its_source(engine: Engine, viewer: Viewer) -> None:
    engine.connect("v", "video")
    await viewer.plays()
    await engine.until("v", StreamStatus.RUNNING)
    engine.source.failure = OSError("the camera was unplugged")
    # A failure that the first retry mends is over before it counts as a stop; this one is not.
    await engine.until("v", StreamStatus.NOT_RUNNING)
    engine.source.failure = None
    await viewer.plays()
    await engine.until("v", StreamStatus.RUNNING)
    assert len(engine.offers) == 1


async def test_trap_6_a_gated_track_takes_another_source_at_once(engine: Engine, viewer: Viewer) -> None:
    engine.connect("v", "video")
    await viewer.plays()
    engine.session.suspend("v")
    await engine.until("v", StreamStatus.SUSPENDED)
    assert engine.video.running_encoders == 0
    engine.session.disconnect("v")
    engine.connect("w", "video")
    await viewer.plays()
    assert [listed.mid for listed in engine.offers[-1].streams] == ["0"]


async def test_trap_7_another_codec_gets_another_section(engine: Engine, viewer: Viewer) -> None:
    engine.connect("v", "video", ["H264"])
    await viewer.plays("0")
    engine.session.disconnect("v")
    engine.connect("w", "video", ["VP8"])
    await viewer.plays("1")
    assert (await engine.session.stats("w")).codec == "video/VP8"
    assert [rendition.mime_type for rendition in engine.video.made if rendition.running] == ["video/VP8"]


async def test_trap_7_a_further_offer_does_not_change_the_codec_of_a_sender_that_has_not_started(
    engine: Engine, viewer: Viewer, monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[int] = []
    start = RtpSender.start

    def watched(self: RtpSender, negotiated: Negotiated, wire: Wire) -> None:
        started.append(negotiated.payload_type)
        engine.news.tell()
        start(self, negotiated, wire)

    monkeypatch.setattr(RtpSender, "start", watched)

    async def respond(offer: Offer) -> None:
        if offer.generation == 2:
            await engine.news.until(lambda: started)
        await viewer.respond(offer)
        if offer.generation == 1:
            engine.connect("a", "audio")

    engine.application = respond
    viewer.bend_offer = lambda sdp: without(sdp, "a=rtpmap:99 ", "a=rtpmap:101 ", "a=fmtp:99 ", "a=fmtp:101 ")
    engine.connect("v", "video")
    await viewer.plays("0")
    await engine.news.until(lambda: len(engine.offers) == 2)
    assert "a=rtpmap:97 VP8/90000" in engine.offers[0].sdp
    assert started[0] == 97


async def test_trap_8_a_stale_answer_of_equal_size_is_dropped(engine: Engine, viewer: Viewer) -> None:
    engine.connect("v", "video")
    await viewer.plays()
    engine.application = None
    engine.session.disconnect("v")
    await engine.news.until(lambda: len(engine.offers) == 2)
    (connection,) = viewer.connections.values()
    with pytest.raises(UnexpectedAnswer):
        await engine.answer(engine.offers[0], connection.localDescription.sdp)
    assert engine.byes == []
    await viewer.respond(engine.offers[1])
    assert viewer.refusals == []


async def test_trap_10_a_viewer_that_closes_ends_its_peer_at_once(engine: Engine, viewer: Viewer) -> None:
    engine.connect("v", "video")
    await viewer.plays()
    (connection,) = viewer.connections.values()
    await connection.close()
    await engine.news.until(lambda: engine.byes, 1.0)
    assert [bye.reason for bye in engine.byes] == ["the application closed the peer connection"]
    await engine.until("v", StreamStatus.NOT_CONNECTED)
    assert engine.changes[-1].ended


async def test_trap_11_loopback_alone_is_enough_when_it_is_named() -> None:
    network = NetworkSettings(interfaces=("127.0.0.1",))
    async with loopback.engine(network=network) as engine, loopback.viewer(engine) as viewer:
        engine.connect("v", "video")
        await viewer.plays()
        assert "c=IN IP4 127.0.0.1" in engine.offers[0].sdp


async def test_trap_12_what_is_sent_keeps_within_the_level_that_is_offered(engine: Engine) -> None:
    engine.connect("v", "video")
    await engine.news.until(lambda: engine.offers)
    offered = {
        int(line.split("profile-level-id=")[1][4:6], 16)
        for line in engine.offers[0].sdp.splitlines()
        if "profile-level-id=" in line
    }
    assert offered == {31}
    async with engine.video.renditions("video/H264")[0].subscribe() as frames:
        data = (await frames.get()).data
    parameters = data.index(b"\x00\x00\x01\x67") + 4
    assert data[parameters + 2] <= 31


async def test_trap_12_larger_pictures_are_offered_with_their_level_and_play(engine: Engine, viewer: Viewer) -> None:
    engine.video._size, engine.video._frame_rate = (1920, 1080), 60.0
    engine.connect("v", "video", ["H264"])
    await viewer.plays()
    levels = {part[4:6] for part in engine.offers[0].sdp.split("profile-level-id=")[1:]}
    assert levels == {"2a"}


async def test_a_session_needs_no_stun_answer_to_begin(engine: Engine, viewer: Viewer) -> None:
    engine.session.ice_servers = (IceServer(urls=("stun:192.0.2.254:9",)),)
    engine.connect("v", "video")
    await engine.news.until(lambda: engine.offers, 4.0)
    await viewer.plays()
