"""When a connection has stopped taking in what is sent to it."""

from openrois.gateway.stalling import Stalling


def test_nothing_that_waits_is_no_stall() -> None:
    stalling = Stalling(10)
    assert not any(stalling.is_over(now, 0) for now in (0, 10, 1000))


def test_bytes_that_wait_have_so_long_and_each_that_is_taken_begins_anew() -> None:
    stalling = Stalling(10)
    stalling.written = 100
    assert [stalling.is_over(now, unsent) for now, unsent in ((0, 50), (9.9, 50), (10, 49), (19.9, 49))] == [False] * 4
    # What is written meanwhile is not taken by that.
    stalling.written += 1000
    assert not stalling.is_over(19.95, 1049)
    assert stalling.is_over(20, 1049)


def test_what_was_taken_whole_is_forgotten() -> None:
    stalling = Stalling(10)
    stalling.written = 10
    assert not stalling.is_over(0, 10)
    assert not stalling.is_over(9, 0)
    stalling.written += 5
    assert not stalling.is_over(11, 5)
    assert stalling.is_over(21, 5)
