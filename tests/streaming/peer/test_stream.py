import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.errors import NoCommonCodec, UnknownStream
from openrois_streaming.liveness import Verdict
from openrois_streaming.peer import stream as stream_module
from openrois_streaming.peer.stream import Stream, StreamChange, StreamTable, choose_codecs
from openrois_streaming.source.uplink_sink import UplinkSelector
from openrois_streaming.state import TRANSITIONS, Party, StreamInput, StreamPhase, StreamStatus
from openrois_streaming.stats import Counters

from tests.support.streaming import VirtualClock
from tests.support.viewing import FakeInlet, FedPublisher, frame


def make(stream_id: str = "s") -> Stream:
    return Stream(stream_id, "engine/Video", "video", FedPublisher(), ("video/H264", "video/VP8"), Counters())


def test_an_application_that_names_no_codecs_is_offered_all() -> None:
    assert choose_codecs("video", None) == ("video/H264", "video/VP8")
    assert choose_codecs("audio", None) == ("audio/opus",)


@pytest.mark.parametrize(
    ("wanted", "chosen"),
    [
        (["VP8"], ("video/VP8",)),
        (["video/vp8"], ("video/VP8",)),
        (["AV1", "VP8", "h264"], ("video/H264", "video/VP8")),
        (["VP8", "VP8"], ("video/VP8",)),
    ],
)
def test_those_of_ours_that_the_application_can_decode_are_chosen_in_our_order(
    wanted: list[str], chosen: tuple[str, ...]
) -> None:
    assert choose_codecs("video", wanted) == chosen


@pytest.mark.parametrize("wanted", [[], ["AV1"], ["opus"], [""], ["audio/H264"]])
def test_nothing_in_common_is_refused(wanted: list[str]) -> None:
    with pytest.raises(NoCommonCodec, match="video"):
        choose_codecs("video", wanted)


def test_missing_codec_is_not_offered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stream_module, "available_codecs", lambda: ("video/VP8", "audio/opus"))
    assert choose_codecs("video", None) == ("video/VP8",)
    with pytest.raises(NoCommonCodec):
        choose_codecs("video", ["H264"])


@pytest.mark.parametrize(
    ("verdicts", "phase"),
    [
        ([], StreamPhase.CONNECTING),
        ([Verdict.UNDECIDED], StreamPhase.IDLE),
        ([Verdict.UNANSWERED], StreamPhase.IDLE),
        ([Verdict.FLOWING], StreamPhase.RUNNING),
        ([Verdict.STALLED, Verdict.FLOWING], StreamPhase.RUNNING),
        ([Verdict.STALLED], StreamPhase.IDLE),
    ],
)
def test_judgements_change_the_phase(verdicts: list[Verdict], phase: StreamPhase) -> None:
    stream = make()
    stream.judge(verdicts)
    assert stream.phase is phase


@pytest.mark.parametrize(
    ("verdicts", "status"),
    [
        ([Verdict.STALLED, Verdict.UNDECIDED], StreamStatus.RUNNING),
        ([Verdict.STALLED, Verdict.STALLED], StreamStatus.NOT_RUNNING),
        ([Verdict.UNDECIDED], StreamStatus.RUNNING),
    ],
)
def test_a_running_stream_stops_when_no_way_is_left(verdicts: list[Verdict], status: StreamStatus) -> None:
    stream = make()
    stream.judge([Verdict.FLOWING])
    stream.judge(verdicts)
    assert stream.status is status


def test_a_suspended_stream_is_not_judged() -> None:
    stream = make()
    stream.apply(StreamInput.SUSPEND)
    assert not stream.is_open
    stream.judge([Verdict.FLOWING])
    assert stream.status is StreamStatus.SUSPENDED


@pytest.mark.parametrize("phase", [phase for phase in StreamPhase if phase is not StreamPhase.ENDED])
@pytest.mark.parametrize("others", [frozenset(), frozenset({Party.APPLICATION}), frozenset({Party.ENGINE})])
@pytest.mark.parametrize("party", Party)
def test_each_takes_back_only_what_it_wanted(phase: StreamPhase, others: frozenset[Party], party: Party) -> None:
    stream = make()
    stream.phase = TRANSITIONS[phase][StreamInput.SUSPEND] if others else phase
    stream.suspended_by = others
    before = stream.phase
    stream.suspend(party)
    assert not stream.is_open
    assert stream.suspended_by == others | {party}
    stream.resume(party)
    assert stream.suspended_by == others - {party}
    assert stream.is_open is not bool(stream.suspended_by)
    if stream.suspended_by:
        assert stream.phase is before


@given(st.lists(st.tuples(st.sampled_from(Party), st.booleans()) | st.sampled_from(Verdict), max_size=30))
def test_no_order_of_requests_passes_media_of_a_suspended_stream(
    events: list[tuple[Party, bool] | Verdict],
) -> None:
    stream, wanted = make(), dict.fromkeys(Party, True)
    for event in events:
        if isinstance(event, Verdict):
            stream.judge([event])
        else:
            party, wanted[party] = event
            (stream.resume if event[1] else stream.suspend)(party)
        assert stream.is_open is all(wanted.values())
        if not stream.is_open:
            assert stream.status in {StreamStatus.SUSPENDED, StreamStatus.NOT_CONNECTED}


def test_sender_is_notified_of_resuming_before_media_arrives() -> None:
    stream = make()
    stream.uplink_selector = UplinkSelector("s", FakeInlet())
    stream.judge([Verdict.FLOWING])
    stream.suspend(Party.ENGINE)
    stream.resume(Party.ENGINE)
    assert stream.status is StreamStatus.NOT_RUNNING


def test_sent_frames_are_counted() -> None:
    counters = Counters()
    counters.sent(frame(1, keyframe=True, data=b"12345"))
    counters.sent(frame(2, data=b"123"))
    assert (counters.frames_sent, counters.key_frames, counters.bytes_sent) == (2, 1, 8)


def test_every_change_is_notified_once_with_the_previous_status() -> None:
    told: list[StreamChange] = []
    clock = VirtualClock(wall=50.0)
    table, stream = StreamTable(told.append, clock), make()
    table.add(stream)
    assert "s" in table
    assert list(table) == [stream]
    assert table["s"] is stream
    table.notify_changes()
    assert told == []
    stream.judge([Verdict.FLOWING])
    table.notify_changes()
    table.notify_changes()
    assert told == [StreamChange("s", "engine/Video", StreamStatus.NOT_CONNECTED, StreamStatus.RUNNING, 50.0)]
    stream.suspend(Party.APPLICATION)
    table.notify_changes()
    stream.resume(Party.APPLICATION)
    stream.judge([Verdict.FLOWING])
    table.notify_changes()
    assert [change.resumed for change in told] == [False, False, True]
    table.end_stream(stream)
    assert "s" not in table
    table.notify_changes()
    table.notify_changes()
    assert [(change.status, change.ended) for change in told[3:]] == [(StreamStatus.NOT_CONNECTED, True)]
    assert not any(change.ended for change in told[:3])
    with pytest.raises(UnknownStream):
        table["s"]


def test_end_of_a_never_connected_stream_is_notified() -> None:
    told: list[StreamChange] = []
    table, stream = StreamTable(told.append, VirtualClock(wall=50.0)), make()
    table.add(stream)
    table.end_stream(stream)
    table.notify_changes()
    table.notify_changes()
    none = StreamStatus.NOT_CONNECTED
    assert told == [StreamChange("s", "engine/Video", none, none, 50.0, ended=True)]
