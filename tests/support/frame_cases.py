"""Valid and invalid WebSocket frames: each case with its name, its bytes and the expected response (RFC 6455)."""

import zlib
from dataclasses import dataclass

from tests.support.frames import (
    BINARY,
    CLOSE,
    CONTINUATION,
    PING,
    PONG,
    TEXT,
    asks,
    closes,
    frame,
    pieces,
    request,
)

KIB = 1024
LONGEST = 64 * KIB


@dataclass(frozen=True)
class Case:
    """One thing to try on a connection of its own.

    Attributes:
        name: what is tried.
        sent: what is sent, each with a write of its own.
        heard: what comes back; where that is no close the connection goes on.
        later: whether a request was answered before.
    """

    name: str
    sent: tuple[bytes, ...]
    heard: tuple[str, ...]
    later: bool = False


def _one(name: str, sent: bytes, *heard: str) -> Case:
    return Case(name, (sent,), heard)


def _closed(name: str, code: int, *sent: bytes) -> Case:
    return Case(name, (b"".join(sent),), (f"close {code}",))


def _bytewise(sent: bytes) -> tuple[bytes, ...]:
    return tuple(sent[index : index + 1] for index in range(len(sent)))


_SHORT = request(1)
_MEDIUM = request(1, size=300)
_WIDE = request(1, note="日本🤖")
_AT = _WIDE.index("日".encode())
_DEFLATE = zlib.compressobj(wbits=-15)
_DEFLATED = _DEFLATE.compress(_SHORT) + _DEFLATE.flush(zlib.Z_SYNC_FLUSH)[:-4]
_COMES_LATE = frame(TEXT, request(1, size=LONGEST))

RIGHT = (
    _one("a message in one frame", asks(1), "answer 1"),
    _one("two messages in one write", asks(1) + asks(2), "answer 1", "answer 2"),
    Case("byte by byte", _bytewise(asks(1)), ("answer 1",)),
    Case("byte by byte, with a long header", _bytewise(frame(TEXT, _MEDIUM)), ("answer 1",)),
    Case("the longest header byte by byte", (*_bytewise(_COMES_LATE[:20]), _COMES_LATE[20:]), ("answer 1",)),
    _one("126 bytes", frame(TEXT, request(1, size=126)), "answer 1"),
    _one("125 bytes", frame(TEXT, request(1, size=125)), "answer 1"),
    _one("65,535 bytes", frame(TEXT, request(1, size=LONGEST - 1)), "answer 1"),
    _one("65,536 bytes", _COMES_LATE, "answer 1"),
    _one("a mask of ones", frame(TEXT, _SHORT, mask=b"\xff" * 4), "answer 1"),
    _one("a mask of anything", frame(TEXT, _MEDIUM, mask=b"\x81\x00\x7f\x88"), "answer 1"),
    _one("an empty text is no JSON", frame(TEXT), "error -32700"),
    _one("an empty text in fragments", pieces(b"", 0, 0), "error -32700"),
    _one("two fragments", pieces(_SHORT, 9), "answer 1"),
    _one("fragments of one byte", pieces(_SHORT, *range(1, len(_SHORT))), "answer 1"),
    _one("an empty fragment first", pieces(_SHORT, 0), "answer 1"),
    _one("an empty fragment last", pieces(_SHORT, len(_SHORT)), "answer 1"),
    _one("empty fragments in between", pieces(_SHORT, 5, 5, 5, 5), "answer 1"),
    _one("as many fragments as there may be", pieces(_SHORT, *[5] * 1023), "answer 1"),
    _one("fragments, twice", pieces(_SHORT, 9) + pieces(request(2), 9), "answer 1", "answer 2"),
    _one("a character in two fragments", pieces(_WIDE, _AT + 1), "answer 1日本🤖"),
    _one("a character in four fragments", pieces(_WIDE, _AT + 7, _AT + 8, _AT + 9), "answer 1日本🤖"),
    _one("a ping", frame(PING), "pong "),
    _one("a ping that says something", frame(PING, b"hello", mask=b"abcd"), "pong hello"),
    _one("a ping of 125 bytes", frame(PING, b"x" * 125), "pong " + "x" * 125),
    _one("a ping that is no text", frame(PING, b"\x00\xff\xfe"), "pong \x00\xff\xfe"),
    Case("a ping byte by byte", _bytewise(frame(PING, b"hello")), ("pong hello",)),
    _one("ten pings", b"".join(frame(PING, b"%d" % n) for n in range(10)), *(f"pong {n}" for n in range(10))),
    _one("an unsolicited pong", frame(PONG, b"here")),
    _one("a pong, then a ping", frame(PONG) + frame(PING, b"x"), "pong x"),
    _one(
        "a ping between fragments",
        frame(TEXT, _SHORT[:9], fin=False) + frame(PING, b"x") + frame(CONTINUATION, _SHORT[9:]),
        "pong x",
        "answer 1",
    ),
    _one(
        "a ping in the middle of a character",
        frame(TEXT, _WIDE[: _AT + 1], fin=False) + frame(PING, b"x") + frame(CONTINUATION, _WIDE[_AT + 1 :]),
        "pong x",
        "answer 1日本🤖",
    ),
    _one("a pong between fragments", frame(TEXT, b"[", fin=False) + frame(PONG) + frame(CONTINUATION), "error -32700"),
    _one("characters that mean nothing", frame(TEXT, "\0\uffff\U0010ffff".encode()), "error -32700"),
    _one("a byte order mark", frame(TEXT, b"\xef\xbb\xbf" + _SHORT), "error -32700"),
)

GOODBYES = (
    _closed("a close without a code", 1000, frame(CLOSE)),
    *(
        _closed(f"a close with code {code}", 1000, closes(code))
        for code in (1000, 1001, 1002, 1003, 1007, 1008, 1009, 1010, 1011, 1012, 1013, 1014, 3000, 3999, 4000, 4999)
    ),
    _closed("a close with the longest reason", 1000, closes(1000, b"x" * 123)),
    _closed("a close with a reason in Japanese", 1000, closes(1000, "日本".encode())),
    Case("a close byte by byte", _bytewise(closes(1000, b"bye")), ("close 1000",)),
    _closed("a request after the close", 1000, closes(1000), asks(1)),
    _closed("a ping after the close", 1000, closes(1000), frame(PING)),
    _closed("a second close", 1000, closes(1000), closes(4999)),
    _closed("what is wrong, after the close", 1000, closes(1000), b"\xff" * 100),
    _closed("a close between fragments", 1000, frame(TEXT, b"x", fin=False), closes(1000)),
    *(
        _closed(f"a close with code {code}, which may not be sent", 1002, closes(code))
        for code in (0, 1, 999, 1004, 1005, 1006, 1015, 1016, 1100, 2000, 2999, 5000, 65535)
    ),
    Case("a code that may not be sent, byte by byte", _bytewise(closes(1006)), ("close 1002",)),
    _closed("such a code behind a mask", 1002, frame(CLOSE, (1006).to_bytes(2, "big"), mask=b"\x03\xe8\x00\x00")),
    _closed("a close with half a code", 1002, frame(CLOSE, b"\x03")),
    _closed("a reason that is no UTF-8", 1007, closes(1000, b"\xff")),
    _closed("a reason with a surrogate", 1007, closes(1000, b"\xed\xa0\x80")),
    _closed("a reason that ends within a character", 1007, closes(1000, b"\xe6\x97")),
    _closed("a close that is too long", 1002, closes(1000, b"x" * 124)),
    _closed("a close in fragments", 1002, frame(CLOSE, fin=False)),
    _closed("a close with a reserved bit", 1002, frame(CLOSE, rsv=4)),
)

RESERVED = (
    *(_closed(f"reserved bits {bits:03b} of a text", 1002, frame(TEXT, _SHORT, rsv=bits)) for bits in range(1, 8)),
    _closed("a reserved bit of a binary message", 1002, frame(BINARY, rsv=1)),
    *(_closed(f"reserved bits {bits:03b} of a ping", 1002, frame(PING, rsv=bits)) for bits in (4, 2, 1)),
    _closed("a reserved bit of a pong", 1002, frame(PONG, rsv=2)),
    _closed(
        "a reserved bit of the second fragment", 1002, frame(TEXT, b"x", fin=False), frame(CONTINUATION, b"y", rsv=4)
    ),
    _closed("a compressed message without a negotiated extension", 1002, frame(TEXT, _DEFLATED, rsv=4)),
    *(_closed(f"opcode {opcode}", 1002, frame(opcode)) for opcode in (3, 4, 5, 6, 7, 11, 12, 13, 14, 15)),
    _closed("opcode 3 with something in it", 1002, frame(3, b"x" * 200)),
    _closed("opcode 15 with something in it", 1002, frame(15, b"x" * 100)),
    _closed("opcode 4 between fragments", 1002, frame(TEXT, b"x", fin=False), frame(4)),
    _closed("opcode 11 between fragments", 1002, frame(TEXT, b"x", fin=False), frame(11)),
    Case("a reserved opcode after a ping", (frame(PING, b"x") + frame(5),), ("pong x", "close 1002")),
    _closed("plain HTTP", 1002, b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"),
    _closed("the beginning of TLS", 1002, bytes.fromhex("16030100c8010000c40303")),
    _closed("nothing but zeros", 1002, bytes(100)),
)

CONTROL = (
    _closed("a ping of 126 bytes", 1002, frame(PING, b"x" * 126)),
    _closed("a ping of 70,000 bytes", 1002, frame(PING, b"x" * 70_000)),
    _closed("a pong of 126 bytes", 1002, frame(PONG, b"x" * 126)),
    _closed("a ping in fragments", 1002, frame(PING, b"x", fin=False)),
    _closed("a ping in fragments that continues", 1002, frame(PING, b"x", fin=False), frame(CONTINUATION, b"y")),
    _closed("a pong in fragments", 1002, frame(PONG, fin=False)),
)

FRAGMENTS = (
    _closed("a continuation of nothing", 1002, frame(CONTINUATION, _SHORT)),
    _closed("an empty continuation of nothing", 1002, frame(CONTINUATION)),
    _closed("a continuation of nothing that is to go on", 1002, frame(CONTINUATION, b"x", fin=False)),
    Case("a continuation of a whole message", (frame(CONTINUATION, b" "),), ("close 1002",), later=True),
    Case("a continuation of a ping", (frame(PING, b"x") + frame(CONTINUATION, b" "),), ("pong x", "close 1002")),
    _closed("a text between fragments", 1002, frame(TEXT, b"[", fin=False), asks(1)),
    _closed("a text that begins between fragments", 1002, frame(TEXT, b"[", fin=False), frame(TEXT, b"[", fin=False)),
    _closed("a binary message between fragments", 1002, frame(TEXT, b"[", fin=False), frame(BINARY, b"x")),
    _closed("a text after an empty fragment", 1002, frame(TEXT, fin=False), asks(1)),
    _closed("a text that begins after an empty fragment", 1002, frame(TEXT, fin=False), frame(TEXT, b"[", fin=False)),
    _closed("a binary message after an empty fragment", 1002, frame(TEXT, fin=False), frame(BINARY, b"x")),
    _closed("more fragments than there may be", 1008, pieces(_SHORT, *[5] * 1024)),
    _closed("70,000 fragments of one byte", 1008, pieces(b" " * 70_000, *range(1, 70_000))),
    _closed(
        "fragments and pings without end",
        1008,
        frame(TEXT, b"[", fin=False),
        (frame(PONG) + frame(0, fin=False)) * 1025,
    ),
)

TEXTS = (
    _closed("a binary message", 1003, frame(BINARY, _SHORT)),
    _closed("an empty binary message", 1003, frame(BINARY)),
    _closed("a binary message in fragments", 1003, frame(BINARY, b"x", fin=False), frame(CONTINUATION, b"y")),
    *(
        _closed(f"no UTF-8: {bytes(wrong).hex(' ')}", 1007, frame(TEXT, b'"' + wrong + b'"'))
        for wrong in (
            b"\xff",
            b"\x80",
            b"\xbf\xbf",
            b"\xc0\x80",
            b"\xc1\xbf",
            b"\xe0\x9f\xbf",
            b"\xed\xa0\x80",
            b"\xed\xa0\xbd\xed\xb8\x80",
            b"\xf0\x8f\xbf\xbf",
            b"\xf4\x90\x80\x80",
            b"\xf8\x88\x80\x80\x80",
            b"\xfc\x84\x80\x80\x80\x80",
            b"\xe6\x97",
        )
    ),
    _closed("no UTF-8 in the first fragment", 1007, frame(TEXT, b"\xff", fin=False), frame(CONTINUATION)),
    _closed("no UTF-8 in the last fragment", 1007, frame(TEXT, b"[", fin=False), frame(CONTINUATION, b"\xff")),
    _closed("a character that goes on wrongly in the next fragment", 1007, pieces(b'"\xe6\x97("', 2)),
    _closed("a character that does not go on in the next fragment", 1007, pieces(b'"\xe6"', 2)),
    _closed("a text that ends within a character, in fragments", 1007, pieces(b"\xf0\x9d\x94", 1, 2)),
    Case("no UTF-8 after a good message", (frame(TEXT, b"\xfe"),), ("close 1007",), later=True),
)

LENGTHS = (
    _closed("0 in two bytes", 1002, frame(TEXT, form=2)),
    _closed("5 in two bytes", 1002, frame(TEXT, b"hello", form=2)),
    _closed("125 in two bytes", 1002, frame(TEXT, b"x" * 125, form=2)),
    _closed("0 in eight bytes", 1002, frame(TEXT, form=8)),
    _closed("126 in eight bytes", 1002, frame(TEXT, b"x" * 126, form=8)),
    _closed("65,535 in eight bytes", 1002, frame(TEXT, request(1, size=LONGEST - 1), form=8)),
    _closed("a ping with 5 in two bytes", 1002, frame(PING, b"hello", form=2)),
    _closed("a close with 2 in eight bytes", 1002, frame(CLOSE, b"\x03\xe8", form=8)),
    _closed("one byte too many is refused by the header alone", 1009, frame(TEXT, length=LONGEST + 1)),
    _closed("a gigabyte", 1009, frame(TEXT, length=1 << 30)),
    _closed("the longest there is", 1009, frame(TEXT, length=(1 << 63) - 1)),
    _closed("the highest bit of a length", 1002, frame(TEXT, length=1 << 63)),
    _closed("all bits of a length", 1002, frame(TEXT, length=(1 << 64) - 1)),
    _closed("one byte too many in two fragments", 1009, pieces(request(1, size=LONGEST + 1), LONGEST)),
    _closed("a fragment that promises too much", 1009, frame(TEXT, b"[", fin=False), frame(0, length=LONGEST)),
    _closed("a binary message that is too long", 1009, frame(BINARY, length=LONGEST + 1)),
)

MASKS = (
    _closed("a text without a mask", 1002, frame(TEXT, _SHORT, mask=None)),
    _closed("an empty text without a mask", 1002, frame(TEXT, mask=None)),
    _closed("a binary message without a mask", 1002, frame(BINARY, b"x", mask=None)),
    _closed("a ping without a mask", 1002, frame(PING, b"x", mask=None)),
    _closed("a pong without a mask", 1002, frame(PONG, mask=None)),
    _closed("a close without a mask", 1002, frame(CLOSE, mask=None)),
    _closed("a continuation without a mask", 1002, frame(TEXT, b"[", fin=False), frame(CONTINUATION, mask=None)),
    Case("a text without a mask after one with it", (frame(TEXT, _SHORT, mask=None),), ("close 1002",), later=True),
)

FLOODS = (
    _closed("no more pongs than there may be", 1008, frame(PONG) * 1100),
    _closed("no more pongs that say something", 1008, frame(PONG, b"x" * 125) * 1100),
)

CASES = (*RIGHT, *GOODBYES, *RESERVED, *CONTROL, *FRAGMENTS, *TEXTS, *LENGTHS, *MASKS, *FLOODS)

WITH_HANDSHAKE = (
    _one("a request", asks(1), "answer 1"),
    _closed("a frame without a mask", 1002, frame(TEXT, _SHORT, mask=None)),
    _closed("what the library refuses, and then what it lets pass", 1002, frame(PING, fin=False), frame(CONTINUATION)),
    _closed("what it closes for another reason, and then that", 1007, frame(TEXT, b"\xff"), frame(CONTINUATION)),
    Case("half a header, and then no mask", (b"\x81", b"\x05hello"), ("close 1002",)),
)
