from openrois_streaming.network.guard import (
    HELD_LIMIT,
    REPLIES_AT_ONCE,
    REPLIES_PER_SECOND,
    SIZE_LIMIT,
    SOURCES_LIMIT,
    Allowance,
    Gate,
    GuardFigures,
)

PEER, STRANGER = ("192.0.2.1", 5000), ("192.0.2.2", 5000)


def gate(permits: bool = True) -> tuple[Gate, GuardFigures]:
    figures = GuardFigures()
    return Gate(lambda host, port: permits, figures), figures


def test_a_stranger_does_not_pass() -> None:
    one, figures = gate()
    assert not one.passes(b"hello", STRANGER)
    assert (figures.strangers, figures.total()) == (1, 1)


def test_what_comes_during_a_check_is_held_and_passes_in_order_when_it_succeeds() -> None:
    one, figures = gate()
    assert one.expect(PEER)
    assert not one.passes(b"1", PEER)
    assert not one.passes(b"2", PEER)
    assert one.expect(PEER), "another check with the same source changes nothing"
    assert one.admit(PEER) == [b"1", b"2"]
    assert one.passes(b"3", PEER)
    assert one.expect(PEER), "it has proven itself"
    assert one.expected == ()
    assert figures.total() == 0


def test_only_a_little_is_held() -> None:
    one, figures = gate()
    one.expect(PEER)
    for _ in range(HELD_LIMIT + 3):
        one.passes(b"x", PEER)
    assert figures.strangers == 3
    assert len(one.admit(PEER)) == HELD_LIMIT


def test_nothing_longer_than_media_ever_is_passes_from_anybody() -> None:
    one, figures = gate()
    one.expect(PEER)
    assert not one.passes(bytes(SIZE_LIMIT + 1), PEER)
    assert one.admit(PEER) == []
    assert not one.passes(bytes(SIZE_LIMIT + 1), PEER)
    assert one.passes(bytes(SIZE_LIMIT), PEER)
    assert (figures.oversized, figures.total()) == (2, 2)


def test_what_was_held_is_dropped_when_the_check_fails() -> None:
    one, figures = gate()
    one.expect(PEER)
    one.passes(b"x", PEER)
    one.forget(PEER)
    one.forget(STRANGER)
    assert figures.strangers == 1
    assert one.admit(PEER) == []


def test_a_source_that_is_not_permitted_is_not_checked() -> None:
    one, figures = gate(permits=False)
    assert not one.expect(PEER)
    assert figures.forbidden == 1


def test_only_so_many_sources_are_checked_at_a_time() -> None:
    one, figures = gate()
    tried = [one.expect(("192.0.2.1", port)) for port in range(SOURCES_LIMIT + 5)]
    assert sum(tried) == SOURCES_LIMIT
    assert figures.forbidden == 5


def test_a_viewer_that_moves_for_ever_is_let_in_and_its_oldest_sources_are_forgotten() -> None:
    one, _ = gate()
    for port in range(SOURCES_LIMIT + 5):
        assert one.expect(("192.0.2.1", port))
        one.admit(("192.0.2.1", port))
    assert list(one.proven) == [("192.0.2.1", port) for port in range(5, SOURCES_LIMIT + 5)]


def test_replies_are_limited() -> None:
    now = [0.0]
    replies = Allowance(lambda: now[0], REPLIES_AT_ONCE, REPLIES_PER_SECOND)
    assert sum(replies.admits() for _ in range(50)) == REPLIES_AT_ONCE
    now[0] = 1.0
    assert sum(replies.admits() for _ in range(50)) == REPLIES_PER_SECOND
    now[0] = 1000.0
    assert sum(replies.admits() for _ in range(50)) == REPLIES_AT_ONCE
