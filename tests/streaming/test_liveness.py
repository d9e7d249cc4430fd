import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.liveness import (
    PROBE_AFTER,
    PROBE_INTERVAL,
    REPORT_AGE,
    SILENCE,
    STALL,
    Arrival,
    Flow,
    Verdict,
    Viewer,
    both,
)


def playing(kind: str, until: float, *, reported: bool) -> Flow:
    """A flow opened at 0 whose frames leave every 0.1 s; each is reported at once if `reported`."""
    flow = Flow(kind)
    flow.opened(0.0)
    for number in range(round(until * 10) + 1):
        flow.left(number / 10)
        if reported:
            flow.reported(number, number / 10)
    return flow


def test_nothing_is_said_about_a_flow_that_is_not_open() -> None:
    flow = Flow("video")
    assert flow.judge(5.0, 5.0) is Verdict.UNDECIDED
    flow.opened(5.0)
    flow.closed()
    assert flow.judge(50.0, 50.0) is Verdict.UNDECIDED


@pytest.mark.parametrize("kind", ["video", "audio"])
def test_an_open_flow_without_a_frame_has_stalled_after_a_second(kind: str) -> None:
    flow = Flow(kind)
    flow.opened(10.0)
    assert flow.judge(10.0 + STALL - 0.01, 10.0) is Verdict.UNDECIDED
    assert flow.judge(10.0 + STALL, 10.0) is Verdict.STALLED


@pytest.mark.parametrize("kind", ["video", "audio"])
def test_a_source_that_stops_has_stalled_after_a_second_and_flows_again_at_once(kind: str) -> None:
    flow = playing(kind, 3.0, reported=True)
    assert flow.judge(3.0 + STALL - 0.01, 3.0) is Verdict.FLOWING
    assert flow.judge(3.0 + STALL, 3.0) is Verdict.STALLED
    flow.left(4.5)
    flow.reported(99, 4.5)
    assert flow.judge(4.5, 4.5) is Verdict.FLOWING


def test_video_flows_when_the_first_report_of_progress_has_come() -> None:
    flow = playing("video", 1.0, reported=False)
    assert flow.judge(1.0, 1.0) is Verdict.UNDECIDED
    flow.reported(1, 1.0)
    assert flow.judge(1.0, 1.0) is Verdict.FLOWING


@pytest.mark.parametrize("kind", ["video", "audio"])
def test_frames_that_are_never_reported_do_not_reach_the_viewer(kind: str) -> None:
    flow = playing(kind, REPORT_AGE[kind] + 0.1, reported=False)
    assert flow.judge(REPORT_AGE[kind] + 0.1, 100.0) is Verdict.STALLED


@pytest.mark.parametrize("kind", ["video", "audio"])
def test_reports_without_progress_do_not_count(kind: str) -> None:
    flow = playing(kind, 1.0, reported=True)
    stuck = 10
    for tenths in range(11, round(10 * REPORT_AGE[kind]) + 12):
        flow.left(tenths / 10)
        flow.reported(stuck, tenths / 10)
    assert flow.judge(1.1 + REPORT_AGE[kind] - 0.01, 1.0) is Verdict.FLOWING
    assert flow.judge(1.1 + REPORT_AGE[kind] + 0.01, 1.1) is Verdict.STALLED


def test_single_pictures_with_a_pause_between_them_flow_as_long_as_each_is_reported() -> None:
    flow, pause = playing("video", 1.0, reported=True), 1.5
    assert flow.judge(3.4, 3.4, pause) is Verdict.FLOWING, "the first may come when the pause is over"
    for number in range(1, 10):
        at = 1.0 + number * 2.4
        assert flow.judge(at, at, pause) is Verdict.FLOWING
        flow.left(at, pause)
        assert flow.judge(at + 1.9, at, pause) is Verdict.FLOWING, "its report is still to come"
        flow.reported(1000 + number, at + 1.9)
    assert flow.judge(25.0, 25.0) is Verdict.FLOWING, "the next picture is one of many again, and not due yet"
    assert flow.judge(22.6 + STALL + pause, 25.0, pause) is Verdict.STALLED


def test_single_pictures_that_are_not_reported_do_not_reach_the_viewer() -> None:
    flow = playing("video", 1.0, reported=True)
    for number in range(1, 4):
        flow.left(1.0 + number * 1.5, 1.5)
    assert flow.judge(2.5 + REPORT_AGE["video"], 1.0, 1.5) is Verdict.FLOWING
    assert flow.judge(2.6 + REPORT_AGE["video"], 1.0, 1.5) is Verdict.STALLED


def test_a_source_that_goes_on_after_a_long_stop_flows_when_that_is_reported() -> None:
    flow = playing("video", 1.0, reported=True)
    flow.left(5.0)
    assert flow.judge(5.0, 5.0) is Verdict.STALLED
    flow.reported(99, 5.1)
    assert flow.judge(5.1, 5.1) is Verdict.FLOWING


def test_audio_flows_towards_a_viewer_that_is_there_before_its_first_report() -> None:
    flow = playing("audio", 2.0, reported=False)
    assert flow.judge(2.0, -1.0) is Verdict.UNANSWERED
    assert flow.judge(2.0, 0.0) is Verdict.FLOWING


def test_sound_that_returns_after_a_long_silence_has_its_time_until_it_is_reported() -> None:
    flow = playing("audio", 5.0, reported=True)
    flow.left(5.1)
    assert flow.judge(5.1 + STALL, 5.0) is Verdict.STALLED
    for tenths in range(150, 230):
        flow.left(tenths / 10)
        assert flow.judge(tenths / 10, 15.0) is Verdict.FLOWING
    for tenths in range(230, 232):
        flow.left(tenths / 10)
    assert flow.judge(23.1, 15.0) is Verdict.STALLED, "none of it was reported"


def test_sound_with_gaps_that_is_never_reported_does_not_flow_for_ever() -> None:
    flow = playing("audio", 5.0, reported=True)
    for seconds in range(6, 30, 2):
        flow.left(float(seconds))
    assert flow.judge(28.0, 5.0) is Verdict.STALLED


@pytest.mark.parametrize("kind", ["video", "audio"])
def test_time_in_which_a_stream_is_suspended_does_not_count(kind: str) -> None:
    flow = playing(kind, 1.0, reported=True)
    flow.closed()
    flow.reported(10, 99.0)
    flow.opened(100.0)
    assert flow.judge(100.5, 100.0) is Verdict.UNDECIDED
    flow.left(100.5)
    assert flow.judge(100.5, 100.0) is Verdict.FLOWING
    for tenths in range(1006, round(10 * (100.0 + REPORT_AGE[kind])) + 2):
        flow.left(tenths / 10)
    assert flow.judge(100.1 + REPORT_AGE[kind], 100.0) is Verdict.STALLED


def test_reports_on_the_stream_before_say_nothing_about_this_one() -> None:
    flow = Flow("video", highest_sequence=77)
    flow.opened(0.0)
    flow.left(0.0)
    flow.reported(77, 0.1)
    assert flow.judge(0.1, 0.1) is Verdict.UNDECIDED
    flow.reported(78, 0.2)
    assert flow.judge(0.2, 0.2) is Verdict.FLOWING


@given(
    st.lists(
        st.tuples(
            st.floats(0.0, 1.5), st.sampled_from(["left", "reported", "same", "closed", "opened"]), st.booleans()
        ),
        max_size=40,
    ),
    st.sampled_from(["video", "audio"]),
)
def test_only_fresh_evidence_makes_a_flow(steps: list[tuple[float, str, bool]], kind: str) -> None:
    flow, now, sequence, left, is_open = Flow(kind), 0.0, 0, float("-inf"), False
    for wait, event, seen in steps:
        now += wait
        match event:
            case "left":
                flow.left(now)
                left = now
            case "reported":
                sequence += 1
                flow.reported(sequence, now)
            case "same":
                flow.reported(sequence, now)
            case "closed":
                flow.closed()
                is_open = False
            case _:
                flow.opened(now)
                left, is_open = float("-inf"), True
        verdict = flow.judge(now, now if seen else -1.0)
        if verdict is Verdict.FLOWING:
            assert is_open
            assert now - left < STALL
        if is_open and left > float("-inf") and now - left >= STALL:
            assert verdict is Verdict.STALLED


def test_a_silent_viewer_is_gone_after_four_seconds() -> None:
    viewer = Viewer(10.0)
    assert viewer.seen == viewer.since == 10.0
    viewer.alive(11.0)
    assert not viewer.gone(11.0 + SILENCE - 0.01)
    assert viewer.gone(11.0 + SILENCE)
    assert viewer.since == 10.0


def test_a_silent_viewer_is_asked_several_times_before_it_is_gone() -> None:
    viewer = Viewer(0.0)
    asked = [step / 10 for step in range(round(SILENCE * 10)) if viewer.ask(step / 10, urgent=False)]
    assert asked[0] == PROBE_AFTER
    assert len(asked) >= 3
    assert all(later - earlier >= PROBE_INTERVAL for earlier, later in itertools.pairwise(asked))


def test_a_viewer_that_speaks_is_not_asked_unless_it_is_urgent() -> None:
    viewer = Viewer(0.0)
    for step in range(100):
        viewer.alive(step / 10)
        assert not viewer.ask(step / 10, urgent=False)
    assert viewer.ask(10.0, urgent=True)
    assert not viewer.ask(10.1, urgent=True)
    assert viewer.ask(10.0 + PROBE_INTERVAL, urgent=True)


def test_standstill_of_the_process_is_not_silence() -> None:
    viewer = Viewer(0.0)
    viewer.excuse(30.0)
    assert not viewer.gone(31.0)
    assert viewer.gone(30.1 + SILENCE)


def test_nothing_is_known_while_nothing_is_wanted() -> None:
    arrival = Arrival()
    assert arrival.judge(10.0, 10.0) is Verdict.UNDECIDED
    arrival.opened(10.0)
    arrival.closed()
    assert arrival.judge(20.0, 20.0) is Verdict.UNDECIDED


@pytest.mark.parametrize("last", [None, 9.0])
def test_the_first_frame_has_its_time(last: float | None) -> None:
    arrival = Arrival()
    arrival.opened(10.0)
    assert arrival.judge(10.0 + STALL / 2, last) is Verdict.UNDECIDED
    assert arrival.judge(10.0 + STALL, last) is Verdict.STALLED


def test_uplink_flows_while_frames_come() -> None:
    arrival = Arrival()
    arrival.opened(10.0)
    assert arrival.judge(10.5, 10.4) is Verdict.FLOWING
    assert arrival.judge(10.4 + STALL, 10.4) is Verdict.STALLED
    assert arrival.judge(30.0, 29.9) is Verdict.FLOWING


@pytest.mark.parametrize(
    ("verdicts", "together"),
    [
        ([], Verdict.UNDECIDED),
        ([Verdict.FLOWING], Verdict.FLOWING),
        ([Verdict.FLOWING, Verdict.STALLED], Verdict.STALLED),
        ([Verdict.UNDECIDED, Verdict.STALLED], Verdict.STALLED),
        ([Verdict.UNANSWERED, Verdict.FLOWING], Verdict.UNANSWERED),
        ([Verdict.FLOWING, Verdict.UNDECIDED], Verdict.UNDECIDED),
        ([Verdict.FLOWING, Verdict.FLOWING], Verdict.FLOWING),
    ],
)
def test_both_directions_count(verdicts: list[Verdict], together: Verdict) -> None:
    assert both(verdicts) is together
