"""The playout delay of viewers, from their reports."""

from collections.abc import Iterator
from dataclasses import dataclass

import pytest
from openrois_body.speech.playout_delay import DEVICE, LONGEST, PLAYOUT, PlayoutDelay, way
from openrois_streaming.errors import UnknownStream
from openrois_streaming.state import StreamStatus

REF = "avatar/audio_streaming"


@dataclass
class Stats:
    round_trip_time: float | None
    jitter: float | None
    component_ref: str = REF
    status: StreamStatus = StreamStatus.RUNNING
    playout_delay: float | None = None


class Session:
    """A session as far as it is asked for figures; a stream without any has ended meanwhile."""

    def __init__(self, **streams: Stats | None) -> None:
        self._streams = streams
        self.stream_ids = tuple(streams)

    async def stats(self, stream_id: str) -> Stats:
        found = self._streams[stream_id]
        if found is None:
            raise UnknownStream("there is no such stream")
        return found


class Sessions:
    def __init__(self, *sessions: Session) -> None:
        self._sessions = sessions

    def __iter__(self) -> Iterator[Session]:
        return iter(self._sessions)


async def lateness(*sessions: Session) -> float:
    playout_delay = PlayoutDelay()
    playout_delay.observe_sessions(Sessions(*sessions), REF)  # type: ignore[arg-type]
    return await playout_delay.lateness()


def test_a_way_is_half_a_round_trip_and_a_buffer_that_grows_with_the_jitter() -> None:
    assert way(None, None) == PLAYOUT
    assert way(0.05, 0.01) == pytest.approx(PLAYOUT + 0.025 + 0.03)
    assert way(5.0, 0.0) == LONGEST


def test_reported_buffer_of_a_viewer_replaces_the_estimate() -> None:
    assert way(0.05, 0.01, 0.12) == pytest.approx(0.12 + DEVICE + 0.025)
    assert way(None, None, 0.0) == DEVICE
    assert way(0.1, 0.5, 60.0) == LONGEST


async def test_slowest_viewer_counts_with_reported_playout_delay() -> None:
    slow, near = Stats(0.01, 0.0, playout_delay=0.4), Stats(0.01, 0.0, playout_delay=0.05)
    silent = Stats(0.01, 0.0)
    assert await lateness(Session(near=near, silent=silent)) == pytest.approx(PLAYOUT + 0.005)
    assert await lateness(Session(near=near), Session(slow=slow)) == pytest.approx(0.4 + DEVICE + 0.005)
    gone = Stats(0.01, 0.0, status=StreamStatus.NOT_RUNNING, playout_delay=0.9)
    assert await lateness(Session(near=near, gone=gone)) == pytest.approx(0.05 + DEVICE + 0.005)


async def test_longest_delay_of_all_viewers_counts() -> None:
    near, far = Stats(0.01, 0.0), Stats(0.2, 0.0)
    assert await lateness(Session(near=near), Session(far=far)) == pytest.approx(PLAYOUT + 0.1)


@pytest.mark.parametrize(
    "stream",
    [
        None,
        Stats(0.2, 0.0, component_ref="avatar/video_streaming"),
        Stats(0.2, 0.0, status=StreamStatus.SUSPENDED),
        Stats(0.2, 0.0, status=StreamStatus.NOT_RUNNING),
    ],
)
async def test_viewer_without_a_running_stream_is_not_waited_for(stream: Stats | None) -> None:
    assert await lateness(Session(a=stream)) == PLAYOUT


async def test_delay_without_viewers_is_that_of_a_near_one() -> None:
    assert await lateness() == PLAYOUT
    assert await PlayoutDelay().lateness() == PLAYOUT
