import errno
import os
import socket
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.send.bursts import SEGMENTS_LIMIT, BurstSocket, runs


class Ends:
    """A socket that sends in bursts, and one that receives."""

    def __init__(self) -> None:
        self.receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.receiver.bind(("127.0.0.1", 0))
        self.receiver.settimeout(5)
        self.original = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.burst = BurstSocket(os.dup(self.original.fileno()), socket.AF_INET)

    def arrives(self, datagrams: list[bytes]) -> list[bytes]:
        self.burst.send(datagrams, self.receiver.getsockname())
        return [self.receiver.recv(2000) for _ in datagrams]


@pytest.fixture
def ends() -> Iterator[Ends]:
    ends = Ends()
    yield ends
    ends.burst.close()
    assert ends.original.fileno() >= 0, "what the handle was made of is still open"
    ends.original.close()
    ends.receiver.close()


DATAGRAMS = [b"a" * 300, *(bytes((number,)) * 1200 for number in range(60)), b"b" * 100, b"c" * 1200, b"d"]


def test_datagrams_arrive_one_by_one_in_their_order(ends: Ends) -> None:
    assert ends.arrives(DATAGRAMS) == DATAGRAMS
    assert ends.arrives([]) == []
    assert ends.burst.lost == 0


def test_where_nothing_can_be_sent_together_each_is_sent_alone(ends: Ends) -> None:
    def refuse(*arguments: object) -> int:
        raise OSError(errno.EIO, "the card cannot")

    kept = ends.burst._socket
    ends.burst._socket = Stubborn(kept, refuse)  # type: ignore[assignment]
    assert ends.arrives(DATAGRAMS[:4]) == DATAGRAMS[:4]
    ends.burst._socket = kept
    assert not ends.burst._segmenting
    assert ends.arrives(DATAGRAMS[:4]) == DATAGRAMS[:4]


def test_a_system_that_does_not_know_of_it_is_asked_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("openrois_streaming.send.bursts.UDP_SEGMENT", 0x7FFF)
    ends = Ends()
    assert not ends.burst._segmenting
    assert ends.arrives(DATAGRAMS[:3]) == DATAGRAMS[:3]
    for each in (ends.burst, ends.original, ends.receiver):
        each.close()


def test_refused_datagrams_are_counted_as_lost(ends: Ends) -> None:
    def full(*arguments: object) -> int:
        raise BlockingIOError

    kept = ends.burst._socket
    ends.burst._socket = Stubborn(kept, full)  # type: ignore[assignment]
    ends.burst.send([b"a", b"b", b"longer"], ("127.0.0.1", 9))
    ends.burst._socket = kept
    assert ends.burst.lost == 3
    assert ends.burst._segmenting


def test_a_passing_obstacle_does_not_end_bursts(ends: Ends) -> None:
    def unreachable(*arguments: object) -> int:
        raise OSError(errno.ENETUNREACH, "no route")

    kept = ends.burst._socket
    ends.burst._socket = Stubborn(kept, unreachable)  # type: ignore[assignment]
    assert ends.arrives(DATAGRAMS[:3]) == DATAGRAMS[:3]
    ends.burst._socket = kept
    assert ends.burst._segmenting


class Stubborn:
    """A socket that does not send several datagrams at once, and one alone only if `alone` does."""

    def __init__(self, real: socket.socket, refuse: object) -> None:
        self.sendmsg = refuse
        self.sendto = refuse if getattr(refuse, "__name__", "") == "full" else real.sendto


@given(st.lists(st.integers(0, 1400), max_size=150))
def test_each_run_can_go_together(lengths: list[int]) -> None:
    cut = list(runs(lengths))
    assert [index for first, end in cut for index in range(first, end)] == list(range(len(lengths)))
    for first, end in cut:
        run = lengths[first:end]
        assert 0 < len(run) <= SEGMENTS_LIMIT
        assert sum(run) <= 65_507
        assert all(length == run[0] for length in run[:-1])
        assert run[-1] <= run[0]
