import asyncio
import logging
from collections.abc import AsyncIterator

import pytest
from aiortc.rtp import RtpPacket
from openrois_signaling.messages import SDP_LIMIT, Answer, Bye, Candidate, CaptureClocks, Downward, Offer
from openrois_signaling.negotiation import ANSWER_TIMEOUT, APPLY_TIMEOUT, PREPARE_TIMEOUT
from openrois_streaming.clock import wall_at
from openrois_streaming.errors import (
    InvalidCandidate,
    InvalidDescription,
    NoEncoder,
    NoPath,
    PeerClosed,
    StaleGeneration,
    TooManyCandidates,
    TooManySections,
    UnexpectedAnswer,
    UnknownPeer,
)
from openrois_streaming.liveness import SILENCE, Verdict
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.network.turns import Ingress
from openrois_streaming.peer import peer as peer_module
from openrois_streaming.peer.downlink import PREPARATION
from openrois_streaming.peer.input_channels import Channels
from openrois_streaming.peer.peer import CLOCKS_INTERVAL, CONNECT_TIMEOUT, Peer
from openrois_streaming.peer.stream import Stream
from openrois_streaming.publish.key_frames import KeyFrameCause
from openrois_streaming.state import Party, StreamInput
from openrois_streaming.stats import Counters
from openrois_streaming.tasks import OwnedTasks

from tests.support.streaming import VirtualClock, settle
from tests.support.viewing import FedPublisher, WirelessConnection, frame


class Owner:
    """Owns one peer connection and remembers what it said."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.publisher = FedPublisher()
        self.failures: list[BaseException] = []
        self.said: list[Downward] = []
        self.ended: list[str] = []
        self.declined: list[str] = []
        self.changes = 0
        self.answers = 0
        self.tasks = OwnedTasks("peer", self.failures.append)
        self.peer = Peer(
            "engine/p",
            replaces="engine/o",
            ice_servers=(),
            network=NetworkSettings(),
            guarded=GuardFigures(),
            ingress=Ingress(),
            clock=self.clock,
            tasks=self.tasks,
            owner=self,
            channels=Channels,
        )
        self.connection = WirelessConnection.made[-1]

    def peer_says(self, message: Downward) -> None:
        self.said.append(message)

    def peer_answered(self) -> None:
        self.answers += 1

    def peer_changed(self, peer: Peer) -> None:
        self.changes += 1

    def peer_declined(self, peer: Peer, stream: Stream) -> None:
        self.declined.append(stream.stream_id)
        peer.detach(stream)

    def peer_ended(self, peer: Peer) -> None:
        self.ended.append(peer.peer_id)

    def peer_muted(self, reason: str) -> None:
        raise AssertionError(reason)

    def attach(self, name: str = "s") -> Stream:
        stream = Stream(name, "engine/Video", "video", self.publisher, ("video/VP8",), Counters())
        self.peer.attach(stream)
        return stream

    async def answer(self, generation: int = 1, sdp: str = "answer") -> None:
        await settle()
        await self.peer.answer(Answer(peer_id="engine/p", generation=generation, sdp=sdp))

    async def trickle(self, candidate: str | None, generation: int = 1) -> None:
        await self.peer.candidate(
            Candidate(peer_id="engine/p", generation=generation, candidate=candidate, sdp_mid="0")
        )

    async def play(self) -> Stream:
        """A stream that is answered, connected and flowing."""
        stream = self.attach()
        await self.answer()
        self.connection.become("connected")
        await settle()
        await self.publisher.renditions("video/VP8")[0].show(keyframe=True)
        self.connection.report(1)
        return stream

    @property
    def clocks(self) -> list[CaptureClocks]:
        return [message for message in self.said if isinstance(message, CaptureClocks)]

    @property
    def reasons(self) -> list[str]:
        return [message.reason for message in self.said if isinstance(message, Bye)]


@pytest.fixture
async def owner(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Owner]:
    monkeypatch.setattr(peer_module, "BundledConnection", WirelessConnection)
    WirelessConnection.made = []
    owner = Owner()
    yield owner
    owner.peer.end("the test is over")
    await owner.peer.closed()
    await owner.tasks.aclose()
    assert owner.failures == []
    assert owner.connection.closed
    assert owner.ended == ["engine/p"]
    assert all(rendition.readers == 0 for rendition in owner.publisher.made.values())


async def test_streams_that_come_together_are_offered_together(owner: Owner) -> None:
    owner.attach("a")
    owner.attach("b")
    await settle()
    offer = owner.said[0]
    assert isinstance(offer, Offer)
    assert len(owner.said) == 1
    assert (offer.generation, offer.replaces) == (1, "engine/o")
    assert [(each.mid, each.stream_id, each.direction) for each in offer.streams] == [
        ("0", "a", "recvonly"),
        ("1", "b", "recvonly"),
    ]


async def test_what_changes_while_an_offer_is_out_goes_into_the_next(owner: Owner) -> None:
    first = owner.attach("a")
    await settle()
    owner.attach("b")
    owner.peer.detach(first)
    await settle()
    assert len(owner.said) == 1
    await owner.answer()
    await settle()
    offer = owner.said[1]
    assert isinstance(offer, Offer)
    assert (offer.generation, [each.stream_id for each in offer.streams]) == (2, ["b"])


async def test_an_idle_section_is_taken_over_by_a_stream_of_its_codec(owner: Owner) -> None:
    first = await owner.play()
    owner.peer.detach(first)
    owner.attach("b")
    assert len(owner.connection.sections) == 1
    other = Stream("c", "engine/Video", "video", owner.publisher, ("video/H264",), Counters())
    owner.peer.attach(other)
    assert len(owner.connection.sections) == 2


async def test_a_full_peer_takes_no_more_and_goes_on(owner: Owner) -> None:
    owner.connection.room = 1
    owner.attach("a")
    with pytest.raises(TooManySections):
        owner.attach("b")
    await owner.answer()
    assert not owner.peer.ended


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


async def test_a_stale_answer_and_a_stale_candidate_are_refused_and_change_nothing(owner: Owner) -> None:
    stream = await owner.play()
    owner.peer.detach(stream)
    await settle()
    for generation in (1, 3):
        with pytest.raises(UnexpectedAnswer):
            await owner.answer(generation)
    with pytest.raises(StaleGeneration):
        await owner.trickle("candidate", generation=3)
    await owner.answer(2)
    with pytest.raises(StaleGeneration):
        await owner.trickle("candidate", generation=1)
    assert not owner.peer.ended


async def test_candidates_of_the_answer_come_before_those_that_were_held(owner: Owner) -> None:
    owner.attach()
    await settle()
    await owner.trickle("early")
    await owner.trickle(None)
    with pytest.raises(InvalidCandidate):
        await owner.trickle("garbage")
    assert owner.connection.candidates == []
    await owner.answer(sdp="answer inside")
    assert owner.connection.candidates == ["inside", "early"]
    await owner.trickle("late")
    await owner.trickle(None)
    assert owner.connection.candidates[-1] == "late"
    with pytest.raises(InvalidCandidate):
        await owner.trickle("garbage")


async def test_candidates_are_bounded(owner: Owner) -> None:
    owner.attach()
    await owner.answer()
    for number in range(64):
        await owner.trickle(str(number))
    with pytest.raises(TooManyCandidates):
        await owner.trickle("one more")


async def test_an_answer_that_cannot_be_used_ends_the_peer_for_good(owner: Owner) -> None:
    owner.attach()
    with pytest.raises(InvalidDescription, match="it is garbage"):
        await owner.answer(sdp="garbage")
    assert owner.reasons == ["it is garbage"]
    assert owner.peer.ended
    with pytest.raises(UnknownPeer):
        await owner.answer()
    with pytest.raises(UnknownPeer):
        await owner.trickle("candidate")
    owner.peer.end("again")
    assert owner.reasons == ["it is garbage"]


async def test_an_answer_is_applied_also_when_its_sender_leaves(owner: Owner) -> None:
    owner.attach()
    await settle()
    owner.connection.obstacle = asyncio.Event()
    answering = asyncio.create_task(owner.answer())
    await settle()
    await settle()
    answering.cancel()
    await asyncio.wait({answering})
    owner.connection.obstacle.set()
    await settle()
    await owner.trickle("late")
    assert owner.connection.candidates == ["late"]


@pytest.mark.parametrize(
    ("stuck", "limit", "reason"),
    [
        ("describe", PREPARE_TIMEOUT, "no description could be made in time"),
        ("answer", ANSWER_TIMEOUT, "the offer was not answered in time"),
        ("apply", APPLY_TIMEOUT, "the answer could not be applied in time"),
        ("connect", CONNECT_TIMEOUT, "no media path to the application was found"),
    ],
)
async def test_what_takes_too_long_ends_the_peer(owner: Owner, stuck: str, limit: float, reason: str) -> None:
    if stuck == "describe":
        owner.connection.obstacle = asyncio.Event()
    owner.attach()
    await settle()
    answering = None
    if stuck == "apply":
        owner.connection.obstacle = asyncio.Event()
    if stuck in {"apply", "connect"}:
        answering = asyncio.create_task(owner.answer())
        await settle()
    await owner.clock.advance(limit - 0.01)
    owner.peer.tick(owner.clock.now())
    assert owner.reasons == []
    await owner.clock.advance(0.02)
    owner.peer.tick(owner.clock.now())
    owner.peer.tick(owner.clock.now())
    assert owner.reasons == [reason]
    if stuck == "apply":
        assert answering is not None
        with pytest.raises(UnknownPeer):
            await answering


async def test_an_offer_that_is_ready_too_late_is_not_sent(owner: Owner) -> None:
    owner.connection.obstacle = asyncio.Event()
    owner.attach()
    await settle()
    owner.connection.obstacle.set()
    owner.peer.end("over")
    await settle()
    assert [type(message) for message in owner.said] == [Bye]


async def test_an_answer_that_is_applied_too_late_counts_for_nothing(owner: Owner) -> None:
    owner.attach()
    await settle()
    owner.connection.obstacle = asyncio.Event()
    answering = asyncio.create_task(owner.answer())
    await settle()
    await settle()
    owner.connection.obstacle.set()
    owner.peer.end("over")
    with pytest.raises(UnknownPeer):
        await answering


@pytest.mark.parametrize("failure", [OSError("no port"), None])
async def test_an_offer_that_cannot_be_made_ends_the_peer(
    owner: Owner, failure: Exception | None, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    if failure is None:

        async def describe(generation: int) -> tuple[str, tuple[()]]:
            return "x" * (SDP_LIMIT + 1), ()

        monkeypatch.setattr(owner.connection, "describe", describe)
    owner.connection.failure = failure
    with caplog.at_level(logging.CRITICAL):
        owner.attach()
        await settle()
    assert owner.reasons == ["no offer could be made"]


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
    owner.peer.end("over")
    owner.peer.detach(stream)
    await settle()
    assert owner.peer.legs == {}
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


async def test_a_candidate_that_is_found_late_follows_the_offer(owner: Owner) -> None:
    owner.attach()
    await owner.answer()
    owner.connection.find("candidate:1 1 udp 1 203.0.114.7 5000 typ srflx")
    owner.connection.find(None)
    found, last = owner.said[-2:]
    assert isinstance(found, Candidate)
    assert (found.peer_id, found.generation, found.sdp_mid) == ("engine/p", 1, "0")
    assert isinstance(last, Candidate)
    assert not last.candidate
    owner.peer.end("enough")
    owner.connection.find("candidate:1 1 udp 1 203.0.114.7 5001 typ srflx")
    assert isinstance(owner.said[-1], Bye), "nothing follows the end"


@pytest.mark.parametrize("refusal", [NoPath, PeerClosed])
async def test_without_a_way_out_the_application_is_told_why(
    owner: Owner, refusal: type[Exception], caplog: pytest.LogCaptureFixture
) -> None:
    owner.connection.failure = refusal("there is no way")
    owner.attach()
    await settle()
    assert owner.reasons == ["there is no way"]
    assert not caplog.records


async def test_the_application_is_told_when_what_it_receives_was_captured(owner: Owner) -> None:
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


async def test_capture_times_are_told_anew_because_the_clock_may_be_set(owner: Owner) -> None:
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


async def test_capture_times_of_a_further_sender_are_told_at_once(owner: Owner) -> None:
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


async def test_what_ran_ahead_is_left_with_the_first_frame_that_is_sent(owner: Owner) -> None:
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
