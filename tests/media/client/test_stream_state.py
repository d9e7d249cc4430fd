"""What a stream is, what it is wanted to be, and which verb comes next."""

from collections.abc import Callable

import pytest
from openrois_media.client.stream_state import Desire, Failure, Problem, StreamState, Verb, next_verb

from openrois.types.codes import StreamStatus

RUNNING, SUSPENDED, DISCONNECTED = Desire.RUNNING, Desire.SUSPENDED, Desire.DISCONNECTED
PROBLEM = Problem("it is refused", ValueError("it is refused"))


@pytest.mark.parametrize(
    ("desire", "connected", "suspended", "verb"),
    [
        (RUNNING, False, False, Verb.CONNECT),
        (RUNNING, True, False, None),
        (RUNNING, True, True, Verb.RESUME),
        (SUSPENDED, False, False, Verb.CONNECT),
        (SUSPENDED, True, False, Verb.SUSPEND),
        (SUSPENDED, True, True, None),
        (DISCONNECTED, False, False, None),
        (DISCONNECTED, True, False, Verb.DISCONNECT),
        (DISCONNECTED, True, True, Verb.DISCONNECT),
    ],
)
def test_next_verb(desire: Desire, connected: bool, suspended: bool, verb: Verb | None) -> None:
    assert next_verb(desire, connected=connected, suspended=suspended) is verb


def running() -> StreamState:
    state = StreamState()
    state.want(RUNNING)
    state.connected("s", 0.0)
    state.reported(StreamStatus.STREAMING_RUNNING, 0.0)
    return state


Event = Callable[[StreamState], object]


def want(desire: Desire) -> Event:
    return lambda it: it.want(desire)


def report(status: StreamStatus) -> Event:
    return lambda it: it.reported(status, 1.0)


def fail(failure: Failure) -> Event:
    return lambda it: it.failed(Verb.SUSPEND, failure, PROBLEM, 1.0)


def suspended(stream_id: str) -> Event:
    return lambda it: it.performed(Verb.SUSPEND, stream_id)


NOT_CONNECTED = StreamStatus.STREAMING_NOT_CONNECTED
RUNS = StreamStatus.STREAMING_RUNNING
HELD = StreamStatus.STREAMING_SUSPENDED

TABLE: dict[str, tuple[list[Event], str | None, StreamStatus | None, Verb | None]] = {
    "it runs": ([], "s", RUNS, None),
    "resumed is running": ([report(StreamStatus.STREAMING_RESUMED)], "s", RUNS, None),
    "the engine ends it": ([report(NOT_CONNECTED)], None, NOT_CONNECTED, Verb.CONNECT),
    "the gateway is lost": ([lambda it: it.lost(None, 1.0)], None, None, Verb.CONNECT),
    "suspend": ([want(SUSPENDED)], "s", RUNS, Verb.SUSPEND),
    "suspended": ([want(SUSPENDED), suspended("s")], "s", RUNS, None),
    "a former connection was suspended": ([want(SUSPENDED), suspended("old")], "s", RUNS, Verb.SUSPEND),
    "the engine has suspended it": ([report(HELD), want(RUNNING)], "s", HELD, Verb.RESUME),
    "released": ([want(DISCONNECTED), StreamState.release], None, NOT_CONNECTED, None),
    "unknown to the engine": ([want(SUSPENDED), fail(Failure.UNSUPPORTED)], None, NOT_CONNECTED, Verb.CONNECT),
    "refused": ([want(SUSPENDED), fail(Failure.REFUSED)], "s", RUNS, Verb.SUSPEND),
}


@pytest.mark.parametrize(("events", "stream_id", "status", "verb"), TABLE.values(), ids=TABLE.keys())
def test_table(events: list[Event], stream_id: str | None, status: StreamStatus | None, verb: Verb | None) -> None:
    state = running()
    for event in events:
        event(state)
    assert (state.stream_id, state.status, state.pending) == (stream_id, status, verb)


def test_attempts_are_further_and_further_apart() -> None:
    state = StreamState()
    state.want(RUNNING)
    now, waits = 0.0, []
    for _ in range(6):
        assert state.due(now) is Verb.CONNECT
        state.failed(Verb.CONNECT, Failure.REFUSED, PROBLEM, now)
        assert state.due(now) is None
        assert state.retry_at is not None
        waits.append(state.retry_at - now)
        now = state.retry_at
    assert waits == [1, 2, 4, 8, 15, 15]
    assert state.problem is PROBLEM
    state.failed(Verb.CONNECT, Failure.REFUSED, PROBLEM, now)
    state.retry_now()
    assert state.due(now) is Verb.CONNECT
    state.connected("s", now)
    assert state.problem is None


def test_media_that_flows_makes_the_next_failure_a_first_one() -> None:
    state = running()
    for flowed, wait in ((False, 1), (False, 2), (True, 1)):
        if flowed:
            state.flowed()
        state.lost(None, 10.0)
        assert state.retry_at == 10.0 + wait
        state.connected("s", 10.0)


def test_no_connection_is_no_problem_of_the_stream() -> None:
    state = StreamState()
    state.want(RUNNING)
    state.failed(Verb.CONNECT, Failure.NO_CONNECTION, PROBLEM, 0.0)
    assert state.problem is None
    assert state.due(0.0) is None


def test_what_could_not_be_suspended_before_it_ran_is_tried_again() -> None:
    state = StreamState()
    state.want(SUSPENDED)
    state.connected("s", 0.0)
    state.failed(Verb.SUSPEND, Failure.REFUSED, PROBLEM, 0.0)
    assert state.due(0.5) is None
    state.reported(StreamStatus.STREAMING_RUNNING, 0.5)
    assert state.due(0.5) is Verb.SUSPEND


@pytest.mark.parametrize(
    ("status", "desire", "flowed", "expected"),
    [
        (StreamStatus.STREAMING_NOT_RUNNING, RUNNING, False, True),
        (StreamStatus.STREAMING_NOT_RUNNING, RUNNING, True, False),
        (StreamStatus.STREAMING_RUNNING, RUNNING, True, True),
        (StreamStatus.STREAMING_SUSPENDED, RUNNING, True, False),
        (StreamStatus.STREAMING_RUNNING, SUSPENDED, True, False),
    ],
)
def test_when_media_is_expected(status: StreamStatus, desire: Desire, flowed: bool, expected: bool) -> None:
    state = running()
    state.reported(status, 0.0)
    state.desire = desire
    assert state.expects_media(flowed=flowed) is expected
    state.lost(None, 0.0)
    assert not state.expects_media(flowed=flowed)
