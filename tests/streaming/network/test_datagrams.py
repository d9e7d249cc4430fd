from aioice import stun
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.network.datagrams import KINDS, STUN_LIMIT, Kind, StunClass, stun_class, transaction_of


def test_the_first_byte_tells() -> None:
    told = {kind: [first for first in range(256) if KINDS[first] is kind] for kind in Kind}
    assert told[Kind.STUN] == list(range(4))
    assert told[Kind.DTLS] == list(range(20, 64))
    assert told[Kind.MEDIA] == list(range(128, 192))
    assert len(told[Kind.OTHER]) == 256 - 4 - 44 - 64


def message(kind: stun.Class) -> bytes:
    return bytes(stun.Message(stun.Method.BINDING, kind, b"t" * 12, {"SOFTWARE": "test"}))


def test_the_header_tells_the_class() -> None:
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
