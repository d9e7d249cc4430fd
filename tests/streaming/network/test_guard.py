from aioice import stun
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.network.guard import (
    HELD_LIMIT,
    KINDS,
    REPLIES_AT_ONCE,
    REPLIES_PER_SECOND,
    SIZE_LIMIT,
    SOURCES_LIMIT,
    STUN_LIMIT,
    Allowance,
    Gate,
    GuardFigures,
    Kind,
    StunClass,
    stun_class,
    transaction_of,
)

PEER, STRANGER = ("192.0.2.1", 5000), ("192.0.2.2", 5000)


def gate(permits: bool = True) -> tuple[Gate, GuardFigures]:
    figures = GuardFigures()
    return Gate(lambda host, port: permits, figures), figures


def test_a_stranger_does_not_pass() -> None:
    one, figures = gate()
    assert not one.passes(b"hello", STRANGER)
    assert (figures.strangers, figures.total()) == (1, 1)


def test_datagrams_held_during_a_check_pass_in_order_when_it_succeeds() -> None:
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


def test_oversized_datagrams_never_pass() -> None:
    one, figures = gate()
    one.expect(PEER)
    assert not one.passes(bytes(SIZE_LIMIT + 1), PEER)
    assert one.admit(PEER) == []
    assert not one.passes(bytes(SIZE_LIMIT + 1), PEER)
    assert one.passes(bytes(SIZE_LIMIT), PEER)
    assert (figures.oversized, figures.total()) == (2, 2)


def test_held_datagrams_are_dropped_when_the_check_fails() -> None:
    one, figures = gate()
    one.expect(PEER)
    one.passes(b"x", PEER)
    one.reject(PEER)
    one.reject(STRANGER)
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


def test_first_byte_gives_the_kind() -> None:
    told = {kind: [first for first in range(256) if KINDS[first] is kind] for kind in Kind}
    assert told[Kind.STUN] == list(range(4))
    assert told[Kind.DTLS] == list(range(20, 64))
    assert told[Kind.MEDIA] == list(range(128, 192))
    assert len(told[Kind.OTHER]) == 256 - 4 - 44 - 64


def message(kind: stun.Class) -> bytes:
    return bytes(stun.Message(stun.Method.BINDING, kind, b"t" * 12, {"SOFTWARE": "test"}))


def test_header_gives_the_stun_class() -> None:
    for kind in stun.Class:
        assert stun_class(message(kind)) is StunClass(kind)
        assert transaction_of(message(kind)) == b"t" * 12


def test_a_wrong_header_is_none() -> None:
    good = message(stun.Class.REQUEST)
    assert stun_class(good[:19]) is None
    assert stun_class(good[:-4]) is None
    assert stun_class(good + b"x") is None
    assert stun_class(good[:4] + b"cook" + good[8:]) is None
    assert stun_class(good[:2] + (STUN_LIMIT - 16).to_bytes(2, "big") + good[4:20] + bytes(STUN_LIMIT - 16)) is None


@given(st.binary(max_size=200))
def test_any_bytes_have_a_class_or_none(data: bytes) -> None:
    assert stun_class(data) in {None, *StunClass}
