import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.state import (
    OPEN,
    STATUS,
    TRANSITIONS,
    IllegalTransition,
    Party,
    StreamInput,
    StreamPhase,
    StreamStatus,
    following,
    resumption,
)


@pytest.mark.parametrize("phase", StreamPhase)
@pytest.mark.parametrize("event", StreamInput)
def test_every_input_in_every_phase_does_what_the_table_says(phase: StreamPhase, event: StreamInput) -> None:
    if event in TRANSITIONS[phase]:
        assert following(phase, event) is TRANSITIONS[phase][event]
    else:
        with pytest.raises(IllegalTransition, match=f"{event.value} while {phase.value}"):
            following(phase, event)


def walk(*events: StreamInput) -> list[StreamStatus]:
    phase = StreamPhase.CONNECTING
    told = [STATUS[phase]]
    for event in events:
        phase = following(phase, event)
        if STATUS[phase] is not told[-1]:
            told.append(STATUS[phase])
    return told


def test_a_stream_that_is_played_suspended_resumed_and_stalled() -> None:
    assert walk(
        StreamInput.UP,
        StreamInput.FLOWING,
        StreamInput.SUSPEND,
        StreamInput.RESUME,
        StreamInput.FLOWING,
        StreamInput.STALLED,
        StreamInput.FLOWING,
        StreamInput.END,
    ) == [
        StreamStatus.NOT_CONNECTED,
        StreamStatus.NOT_RUNNING,
        StreamStatus.RUNNING,
        StreamStatus.SUSPENDED,
        StreamStatus.RUNNING,
        StreamStatus.NOT_RUNNING,
        StreamStatus.RUNNING,
        StreamStatus.NOT_CONNECTED,
    ]


def test_a_resumed_stream_without_media_is_not_running() -> None:
    told = walk(StreamInput.UP, StreamInput.SUSPEND, StreamInput.RESUME, StreamInput.STALLED)
    assert told[-2:] == [StreamStatus.SUSPENDED, StreamStatus.NOT_RUNNING]


def test_a_stream_can_be_suspended_before_it_is_connected() -> None:
    assert walk(StreamInput.SUSPEND, StreamInput.UP) == [StreamStatus.NOT_CONNECTED, StreamStatus.SUSPENDED]
    told = walk(StreamInput.SUSPEND, StreamInput.RESUME, StreamInput.UP)
    assert told == [StreamStatus.NOT_CONNECTED, StreamStatus.NOT_RUNNING]


@pytest.mark.parametrize(
    ("suspended_by", "by", "event"),
    [
        (set(), Party.APPLICATION, StreamInput.RESUME),
        ({Party.APPLICATION}, Party.APPLICATION, StreamInput.RESUME),
        ({Party.ENGINE}, Party.APPLICATION, StreamInput.SUSPEND),
        ({Party.APPLICATION, Party.ENGINE}, Party.APPLICATION, StreamInput.SUSPEND),
        (set(), Party.ENGINE, StreamInput.RESUME),
        ({Party.ENGINE}, Party.ENGINE, StreamInput.RESUME),
        ({Party.APPLICATION}, Party.ENGINE, StreamInput.SUSPEND),
        ({Party.APPLICATION, Party.ENGINE}, Party.ENGINE, StreamInput.SUSPEND),
    ],
)
def test_stream_resumes_when_every_party_has_resumed_it(
    suspended_by: set[Party], by: Party, event: StreamInput
) -> None:
    assert resumption(suspended_by, by) is event


def test_the_table_is_whole() -> None:
    assert set(TRANSITIONS) == set(STATUS) == set(StreamPhase)


@given(st.lists(st.sampled_from(StreamInput), max_size=30))
def test_no_order_of_inputs_sends_media_of_a_suspended_or_ended_stream(events: list[StreamInput]) -> None:
    phase, suspended = StreamPhase.CONNECTING, False
    for event in events:
        if event not in TRANSITIONS[phase]:
            continue
        phase = following(phase, event)
        if event in {StreamInput.SUSPEND, StreamInput.RESUME}:
            suspended = event is StreamInput.SUSPEND
        assert (phase in OPEN) == (not suspended and phase is not StreamPhase.ENDED)
        if STATUS[phase] is StreamStatus.RUNNING:
            assert phase in OPEN
