"""What a NATS server sends: read however it is cut, and refused where it cannot be read."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.cluster.wire import MAX_LINE, ServerParser, WireFault, publication, subscription

pytestmark = pytest.mark.extra(name="cluster")
MOST = 10_000
Message = tuple[int, bytes, bytes, bytes]


class Read:
    """What a parser has read."""

    def __init__(self) -> None:
        self.messages: list[Message] = []
        self.lines: list[bytes] = []
        self.parser = ServerParser(lambda *message: self.messages.append(message), self.lines.append, MOST)


def test_messages_and_lines() -> None:
    read = Read()
    read.parser.feed(
        b"PING\r\nMSG a.b 7 5\r\nhe\r\no\r\n+OK\r\nMSG a 8 reply.to 0\r\n\r\n"
        b"HMSG c 9 16 16\r\nNATS/1.0 503\r\n\r\n\r\nHMSG c 9 r 12 14\r\nNATS/1.0\r\n\r\nhi\r\n-ERR 'no'\r\n"
    )
    assert read.messages == [
        (7, b"a.b", b"", b"he\r\no"),
        (8, b"a", b"", b""),
        (9, b"c", b"NATS/1.0 503\r\n\r\n", b""),
        (9, b"c", b"NATS/1.0\r\n\r\n", b"hi"),
    ]
    assert read.lines == [b"PING", b"+OK", b"-ERR 'no'"]


SENT = st.one_of(
    st.builds(lambda payload: b"MSG s.1 3 %d\r\n%s\r\n" % (len(payload), payload), st.binary(max_size=MOST)),
    st.sampled_from([b"PING\r\n", b"INFO {}\r\n", b"HMSG s 2 4 6\r\nabcdef\r\n"]),
)


@given(st.lists(SENT, max_size=20), st.lists(st.integers(0, 400), max_size=60))
def test_what_comes_may_be_cut_anywhere(sent: list[bytes], lengths: list[int]) -> None:
    data = b"".join(sent)
    whole, cut = Read(), Read()
    whole.parser.feed(data)
    at = 0
    for length in lengths:
        cut.parser.feed(data[at : at + length])
        at += length
    cut.parser.feed(data[at:])
    assert (cut.messages, cut.lines) == (whole.messages, whole.lines)
    assert len(whole.messages) + len(whole.lines) == len(sent)


def test_a_long_message_comes_in_many_pieces() -> None:
    read = Read()
    data = b"MSG a 1 9000\r\n" + b"x" * 9000 + b"\r\nPING\r\n"
    for at in range(0, len(data), 1000):
        read.parser.feed(data[at : at + 1000])
    assert read.messages == [(1, b"a", b"", b"x" * 9000)]
    assert read.lines == [b"PING"]


@pytest.mark.parametrize(
    "data",
    [
        b"MSG \r\n",
        b"MSG a 1\r\n",
        b"MSG a 1 b c 0\r\n\r\n",
        b"HMSG a 1 0\r\n\r\n",
        b"MSG a b c\r\n",
        b"MSG a 1 -1\r\n",
        b"MSG a 1 10001\r\n",
        b"HMSG a 1 7 5\r\nhello\r\n",
        b"HMSG a 1 -7 5\r\nhello\r\n",
        b"HMSG a 1 x 5\r\nhello\r\n",
        b"MSG a 1 2\r\nhello\r\n",
        b"x" * (MAX_LINE + 1),
    ],
)
def test_what_cannot_be_read_is_a_fault(data: bytes) -> None:
    with pytest.raises(WireFault):
        Read().parser.feed(data)


@given(st.lists(st.binary() | SENT))
def test_any_bytes_are_read_or_refused(pieces: list[bytes]) -> None:
    read = Read()
    with suppress(WireFault):
        for piece in pieces:
            read.parser.feed(piece)
    assert sum(len(message[3]) for message in read.messages) <= sum(map(len, pieces))


def test_what_is_sent() -> None:
    assert publication("a.b", b"hello") == b"PUB a.b  5\r\nhello\r\n"
    assert publication("a.b", b"", "c") == b"PUB a.b c 0\r\n\r\n"
    assert subscription("a.*", 7) == b"SUB a.*  7\r\n"
    assert subscription("a.*", 7, "group") == b"SUB a.* group 7\r\n"
