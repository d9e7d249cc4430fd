"""One peer connection: media, signs of life of the viewer, capture clocks, and the end."""

import pytest
from aiortc.rtp import RtpPacket
from openrois_signaling.messages import Bye, CaptureClocks, Offer
from openrois_streaming.clock import wall_at
from openrois_streaming.errors import NoEncoder
from openrois_streaming.liveness import SILENCE, Verdict
from openrois_streaming.peer.downlink import PREPARATION
from openrois_streaming.peer.peer import CLOCKS_INTERVAL
from openrois_streaming.peer.stream import Stream
from openrois_streaming.publish.key_frames import KeyFrameCause
from openrois_streaming.state import Party, StreamInput
from openrois_streaming.stats import Counters

from tests.support.peer_owner import Owner
from tests.support.streaming import settle
from tests.support.viewing import frame


async def test_media_flows_when_the_offer_is_answered_and_the_connection_is_there(owner: Owner) -> None:
    stream = owner.attach()
    assert owner.peer.judge(stream, 0.0) is None
    await owner.answer()
    await settle()
    rendition = owner.publisher.renditions("video/VP8")[0]
    assert (rendition.prepared, rendition.asked) == (1, [])
    owner.connection.become("connected")
    await settle()
    assert rendition.asked == [KeyFrameCause.START]
    await rendition.show(keyframe=True)
    assert owner.peer.judge(stream, owner.clock.now()) is Verdict.UNDECIDED
    owner.connection.report(1)
    assert owner.peer.judge(stream, owner.clock.now()) is Verdict.FLOWING
    assert owner.changes == 2


async def test_a_stream_added_to_a_connected_peer_flows_after_its_own_answer(owner: Owner) -> None:
    await owner.play()
    second = owner.attach("b")
    await settle()
    assert owner.peer.judge(second, owner.clock.now()) is None
    await owner.answer(2)
    assert owner.peer.judge(second, owner.clock.now()) is not None


async def test_a_suspended_stream_leaves_its_rendition_and_a_resumed_one_starts_with_a_key_frame(owner: Owner) -> None:
    stream = await owner.play()
    rendition = owner.publisher.renditions("video/VP8")[0]
    stream.apply(StreamInput.SUSPEND)
    owner.peer.follow()
    await settle()
    assert rendition.readers == 0
    owner.connection.sections[0].key_frame_wanted()
    assert rendition.asked == [KeyFrameCause.START]
    stream.apply(StreamInput.RESUME)
    owner.peer.follow()
    owner.peer.follow()
    await settle()
    assert rendition.readers == 1
    assert rendition.asked == [KeyFrameCause.START] * 2
    assert [type(message) for message in owner.said] == [Offer, CaptureClocks]


async def test_a_key_frame_that_the_viewer_asks_for_is_a_repair(owner: Owner) -> None:
    stream = await owner.play()
    owner.connection.sections[0].key_frame_wanted()
    assert owner.publisher.renditions("video/VP8")[0].asked == [KeyFrameCause.START, KeyFrameCause.REPAIR]
    assert stream.counters.key_frame_requests == 1
    owner.peer.detach(stream)
    owner.peer.detach(stream)
    owner.connection.sections[0].key_frame_wanted()
    owner.connection.report(9)
    owner.connection.sections[0].sender.send(frame(9))
    assert (stream.counters.key_frame_requests, stream.counters.frames_sent) == (1, 1)


async def test_a_viewer_that_is_silent_is_asked_and_then_gone(owner: Owner) -> None:
    await owner.play()
    for _ in range(round(SILENCE / 0.1) - 1):
        await owner.clock.advance(0.1)
        owner.peer.tick(owner.clock.now())
        await settle()
    assert owner.connection.questions >= 3
    assert owner.reasons == []
    await owner.clock.advance(0.2)
    owner.peer.tick(owner.clock.now())
    assert owner.reasons == ["the viewer is gone"]


async def test_a_viewer_that_answers_questions_is_there_for_ever(owner: Owner) -> None:
    stream = await owner.play()
    stream.apply(StreamInput.SUSPEND)
    owner.peer.follow()
    owner.connection.answers_questions = True
    for _ in range(200):
        await owner.clock.advance(0.1)
        owner.peer.tick(owner.clock.now())
        await settle()
    assert owner.reasons == []
    assert owner.connection.questions == 10


async def test_time_in_which_this_process_slept_does_not_count(owner: Owner) -> None:
    await owner.play()
    await owner.clock.advance(60.0)
    owner.peer.tick(owner.clock.now(), late=59.9)
    assert owner.reasons == []


async def test_sound_is_asked_about_at_once(owner: Owner) -> None:
    stream = Stream("a", "engine/Audio", "audio", owner.publisher, ("audio/opus",), Counters())
    owner.peer.attach(stream)
    await owner.answer()
    owner.connection.become("connected")
    owner.connection.answers_questions = True
    await settle()
    await owner.clock.advance(0.6)
    await owner.publisher.renditions("audio/opus")[0].show(keyframe=True)
    assert owner.peer.judge(stream, owner.clock.now()) is Verdict.UNANSWERED
    owner.peer.tick(owner.clock.now())
    await settle()
    assert owner.peer.judge(stream, owner.clock.now()) is Verdict.FLOWING


@pytest.mark.parametrize(
    ("state", "reason"),
    [
        ("failed", "the media path to the application was lost"),
        ("closed", "the application closed the peer connection"),
    ],
)
async def test_a_connection_that_is_lost_ends_the_peer(owner: Owner, state: str, reason: str) -> None:
    await owner.play()
    owner.connection.become("connecting")
    owner.connection.become("connected")
    owner.connection.become(state)
    owner.connection.become("closed")
    assert owner.reasons == [reason]


async def test_a_stream_can_be_taken_from_a_peer_that_has_ended(owner: Owner) -> None:
    stream = await owner.play()
    owner.peer.end_connection("over")
    owner.peer.detach(stream)
    await settle()
    assert owner.peer.stream_paths == {}
    assert [type(message) for message in owner.said] == [Offer, CaptureClocks, Bye]


async def test_rtcp_before_the_connection_is_there_is_no_sign(owner: Owner) -> None:
    owner.connection.hear()
    assert owner.peer.viewer is None


async def test_a_sender_that_failed_ends_the_peer(owner: Owner) -> None:
    await owner.play()
    owner.connection.sender_failed = True
    owner.peer.tick(owner.clock.now())
    assert owner.reasons == ["a sender has failed"]


async def test_an_application_that_does_what_none_has_to_is_given_up(owner: Owner) -> None:
    await owner.play()
    owner.connection.misuse = "the application sends from too many sources (SSRC)"
    owner.peer.tick(owner.clock.now())
    assert owner.reasons == ["the application sends from too many sources (SSRC)"]


async def test_a_stream_that_finds_no_encoder_ends(owner: Owner) -> None:
    owner.publisher.failure = NoEncoder("all encoders of the engine are in use")
    owner.attach()
    await owner.answer()
    owner.connection.become("connected")
    await settle()
    owner.peer.tick(owner.clock.now())
    assert owner.declined == ["s"]


async def test_capture_clocks_are_sent(owner: Owner) -> None:
    owner.clock._move(1000.0123)
    await owner.play()
    [told] = owner.clocks
    [clock] = told.senders
    assert (told.peer_id, clock.mid, clock.ssrc, clock.clock_rate) == ("engine/p", "0", 0xCAFE, 90_000)
    packet = RtpPacket.parse(owner.connection.wires[0].packets[0])
    since = (packet.timestamp - clock.rtp_origin + 2**31) % 2**32 - 2**31
    captured = clock.wall / 1000 + since / clock.clock_rate
    # `FedRendition` begins at 0 of the media clock.
    assert captured == pytest.approx(wall_at(owner.clock, 0.0), abs=0.0001)


async def test_capture_clocks_are_repeated(owner: Owner) -> None:
    await owner.play()
    before = owner.clocks[0].senders[0]
    owner.clock.step_wall(-3600.0)
    owner.clock._move(owner.clock.now() + CLOCKS_INTERVAL - 0.1)
    owner.connection.hear()
    owner.peer.tick(owner.clock.now())
    assert len(owner.clocks) == 1
    owner.clock._move(owner.clock.now() + 0.1)
    owner.peer.tick(owner.clock.now())
    after = owner.clocks[1].senders[0]
    assert after.wall - before.wall == (CLOCKS_INTERVAL - 3600) * 1000
    assert (after.rtp_origin - before.rtp_origin) % 2**32 == CLOCKS_INTERVAL * 90_000


async def test_capture_clocks_of_a_new_sender_are_sent_at_once(owner: Owner) -> None:
    await owner.play()
    owner.attach("b")
    await owner.answer(2)
    owner.peer.tick(owner.clock.now())
    assert [[clock.mid for clock in told.senders] for told in owner.clocks] == [["0"], ["0", "1"]]


async def test_a_suspended_stream_has_no_capture_time(owner: Owner) -> None:
    stream = await owner.play()
    stream.suspend(Party.APPLICATION)
    owner.peer.follow()
    owner.clock._move(owner.clock.now() + CLOCKS_INTERVAL)
    owner.connection.hear()
    owner.peer.tick(owner.clock.now())
    assert len(owner.clocks) == 1


async def test_source_and_encoder_run_ahead_of_the_media_path_for_a_moment_only(owner: Owner) -> None:
    owner.attach()
    await owner.answer()
    await settle()
    rendition = owner.publisher.renditions("video/VP8")[0]
    assert rendition.readers == 1
    await owner.clock.advance(PREPARATION)
    assert rendition.readers == 0, "it may never come"
    owner.connection.become("connected")
    await settle()
    assert (rendition.readers, rendition.prepared) == (1, 1)


async def test_run_ahead_ends_with_the_first_sent_frame(owner: Owner) -> None:
    await owner.play()
    await settle()
    rendition = owner.publisher.renditions("video/VP8")[0]
    assert (rendition.readers, rendition.prepared) == (1, 1)


async def test_a_suspended_stream_runs_nothing_ahead(owner: Owner) -> None:
    stream = owner.attach()
    stream.suspend(Party.APPLICATION)
    await owner.answer()
    await settle()
    assert owner.publisher.made == {}
