import json
import struct
from contextlib import suppress
from itertools import cycle
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from openrois_avatar.link.messages import (
    MAX_VISEMES,
    Bitrate,
    Bye,
    Completed,
    Drive,
    Floor,
    Halt,
    Hello,
    KeyFrame,
    LinkError,
    Log,
    Look,
    Pause,
    Place,
    Quit,
    Reached,
    React,
    Silence,
    Speak,
    Stop,
    Thing,
    Things,
    VideoShape,
    Viseme,
    Walk,
    Waypoint,
    Welcome,
)
from openrois_avatar.link.protocol import (
    AUDIO_HEADER,
    HEADER,
    MAX_AUDIO,
    MAX_JSON,
    MAX_VIDEO,
    VIDEO_HEADER,
    Audio,
    Doorbell,
    Encoded,
    Message,
    MessageType,
    Parser,
    PixelFormat,
    Sender,
    Video,
    encode,
)

HELLO = Hello("puppet", "1.0", VideoShape(4, 2, 30), 1, ("nod",), "secret")
BGRA = Video(1, 2, 4, 2, 16, PixelFormat.BGRA, bytes(range(32)), bottom_up=True)
I420 = Video(2, 3, 4, 2, 6, PixelFormat.I420, bytes(18))
NV12 = Video(2**64 - 1, 2**64 - 1, 2, 2, 2, PixelFormat.NV12, bytes(6))
BELL = Doorbell(5, 6, 4, 2, 6, PixelFormat.I420, 3, bottom_up=True)
CODED = Encoded(6, 7, 4, 2, True, b"\0\0\1\x65")
SOUND = Audio(3, 4, 2, bytes(3840))
SPEAK = Speak("2", 5, (Viseme(0.0, "PP", 1.0),), 100)
FROM_ENGINE: list[Message] = [
    HELLO,
    BGRA,
    I420,
    BELL,
    NV12,
    CODED,
    SOUND,
    Completed("1", "OK"),
    Log("ä"),
    Pause(True),
    Reached("1", 0),
    Place(1.0, 2.0, 0.0),
    Floor(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)), ()),
    Things((Thing("1", "person", 0.0, 1.0, name="Ann"),)),
    Bye("end"),
]
FROM_ADAPTER: list[Message] = [
    Welcome("x"),
    React("1", "nod"),
    SPEAK,
    Silence(),
    Look(0.0, 1.0),
    SOUND,
    Stop(),
    Walk("3", (Waypoint(1.0, 2.0), Waypoint(0.0, 0.0, 1.0)), 1.0),
    Drive(1.0, 0.0, 0.0),
    Halt(),
    KeyFrame(),
    Bitrate(2_000_000),
    Quit(),
    Bye(""),
]
SIDES = [(Sender.ENGINE, FROM_ENGINE), (Sender.ADAPTER, FROM_ADAPTER)]


def wire(*messages: Message) -> bytes:
    return b"".join(b"".join(encode(message)) for message in messages)


def plain(messages: list[Message]) -> list[Message]:
    """With pixels and samples as bytes, so that messages can be compared."""
    return [_plain(message) for message in messages]


def _plain(message: Message) -> Message:
    match message:
        case Video(sequence, timestamp, width, height, stride, pixel_format, pixels, bottom_up):
            return Video(sequence, timestamp, width, height, stride, pixel_format, bytes(pixels), bottom_up)
        case Audio(sequence, timestamp, channels, samples):
            return Audio(sequence, timestamp, channels, bytes(samples))
        case Encoded(sequence, timestamp, width, height, keyframe, data):
            return Encoded(sequence, timestamp, width, height, keyframe, bytes(data))
        case other:
            return other


def greeted(sender: Sender = Sender.ENGINE) -> Parser:
    parser = Parser(sender)
    parser.feed(wire(HELLO if sender is Sender.ENGINE else Welcome("x")))
    return parser


def raw(kind: int, payload: bytes = b"", **changes: Any) -> bytes:
    fields = {
        "magic": b"ORL1",
        "kind": kind,
        "version": 1,
        "flags": 0,
        "length": len(payload),
        "reserved": 0,
        **changes,
    }
    return HEADER.pack(*fields.values()) + payload


def video_payload(pixels: int, *fields: int) -> bytes:
    return VIDEO_HEADER.pack(*fields) + bytes(pixels)


def test_the_headers_have_the_sizes_of_the_format() -> None:
    assert (HEADER.size, VIDEO_HEADER.size, AUDIO_HEADER.size) == (16, 40, 24)


def test_a_message_looks_on_the_wire_as_specified() -> None:
    header, payload = encode(Video(7, 9, 2, 2, 8, PixelFormat.BGRA, bytes(16), bottom_up=True))
    assert header[:16] == b"ORL1" + bytes([3, 1, 0, 0, 56, 0, 0, 0, 0, 0, 0, 0])
    assert struct.unpack("<QQ6I", header[16:]) == (7, 9, 2, 2, 8, 1, 1, 0)
    assert payload == bytes(16)
    header, payload = encode(React("1", "nod"))
    assert header == b"ORL1" + bytes([5, 1, 0, 0, len(payload), 0, 0, 0, 0, 0, 0, 0])
    assert json.loads(bytes(payload)) == {"command": "react", "id": "1", "reaction": "nod"}


@pytest.mark.parametrize(("sender", "messages"), SIDES)
def test_every_message_travels_whole(sender: Sender, messages: list[Message]) -> None:
    assert plain(Parser(sender).feed(wire(*messages))) == messages


@given(st.sampled_from(SIDES), st.lists(st.integers(1, 60) | st.integers(1, 5000), min_size=1, max_size=8))
@settings(max_examples=40, deadline=None)
def test_chunks_do_not_matter(side: tuple[Sender, list[Message]], sizes: list[int]) -> None:
    sender, messages = side
    parser, data, found = Parser(sender), wire(*messages), list[Message]()
    for size in cycle(sizes):
        if not data:
            break
        found += parser.feed(data[:size])
        data = data[size:]
    assert plain(found) == messages


@given(st.sampled_from(SIDES), st.integers(1, 5000))
@settings(max_examples=40, deadline=None)
def test_a_socket_may_write_straight_to_where_the_payload_stays(side: tuple[Sender, list[Message]], most: int) -> None:
    sender, messages = side
    parser, data, found = Parser(sender), wire(*messages), list[Message]()
    while data:
        target = parser.get_buffer()
        count = min(most, len(target), len(data))
        assert count
        target[:count] = data[:count]
        data = data[count:]
        parser.buffer_updated(count, found.append)
    assert plain(found) == messages


def test_several_small_messages_come_with_one_read_and_are_given_until_one_is_broken() -> None:
    parser, found = greeted(), list[Message]()
    data = wire(Log("a"), BELL, SOUND)[:-1]
    parser.get_buffer()[: len(data)] = data
    parser.buffer_updated(len(data), found.append)
    assert found == [Log("a"), BELL]
    data = wire(SOUND)[-1:] + wire(Log("b")) + raw(9)
    parser.get_buffer()[: len(data)] = data
    with pytest.raises(LinkError, match="unknown message type 9"):
        parser.buffer_updated(len(data), found.append)
    assert plain(found[2:]) == [SOUND, Log("b")]


def test_a_whole_picture_is_not_copied() -> None:
    data = bytearray(wire(BGRA))
    (message,) = greeted().feed(data)
    assert isinstance(message, Video)
    data[-1] = 99
    assert message.pixels[-1] == 99
    with pytest.raises(TypeError):
        message.pixels[0] = 1  # type: ignore[index]


def test_payloads_that_arrive_in_pieces_are_put_where_the_caller_says() -> None:
    given_out: list[bytearray] = []

    def allocate(size: int) -> bytearray:
        given_out.append(bytearray(size))
        return given_out[-1]

    parser = Parser(Sender.ENGINE, allocate)
    large = Video(1, 2, 64, 32, 256, PixelFormat.BGRA, bytes(range(256)) * 32)
    data = wire(HELLO, Log("x" * 4000), large)
    parser.feed(data[:-5])
    (message,) = parser.feed(data[-5:])
    assert isinstance(message, Video)
    assert [len(buffer) for buffer in given_out] == [40 + 8192]
    assert plain([message]) == [large]
    message.pixels[0] = 99  # type: ignore[index]
    assert given_out[0][40] == 99


def test_the_header_is_not_overwritten_by_what_follows_an_empty_payload() -> None:
    with pytest.raises(LinkError, match="bad BYE: the payload is not JSON"):
        greeted().feed(raw(MessageType.BYE))
    parser = greeted()
    parser.feed(raw(MessageType.BYE)[:7])
    with pytest.raises(LinkError, match="bad BYE: the payload is not JSON"):
        parser.feed(raw(MessageType.BYE)[7:])


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (raw(6, magic=b"HTTP"), "bad magic: .*; begin each message with ORL1"),
        (raw(6, version=2), "version 2 is not spoken here, only 1; send 1"),
        (raw(6, flags=1), "unknown flags in the header; send 0"),
        (raw(6, reserved=1), "unknown flags in the header; send 0"),
        (raw(0), "unknown message type 0; send one from 1 to 8"),
        (raw(9), "unknown message type 9"),
        (raw(1), "HELLO is not expected here; send one of AUDIO, BYE, EVENT, RING, VIDEO$"),
        (raw(2), "WELCOME is not expected here"),
        (raw(5), "COMMAND is not expected here"),
        (raw(6, length=MAX_JSON + 1), "EVENT of 65537 bytes is over the limit of 65536; send less in one message"),
        (raw(7, length=MAX_JSON + 1), "BYE of 65537"),
        (raw(4, length=MAX_AUDIO + 1), "AUDIO of 65537"),
        (raw(3, length=MAX_VIDEO + 1), "VIDEO of 67108865"),
        (raw(6, b"{"), "bad EVENT: the payload is not JSON: send one object"),
        (raw(6, b"\xff"), "bad EVENT: the payload is not JSON"),
        (raw(6, b'{"event": NaN}'), "bad EVENT: the payload is not JSON"),
        (raw(6, b"[" * 60_000), "bad EVENT: the payload is not JSON"),
        (raw(6, b"1" * 60_000), "bad EVENT: the payload is not JSON"),
        (raw(6, b"[]"), "bad EVENT: the payload is not a JSON object: send one"),
        (raw(6, b"{}"), "bad EVENT: event: expected a string"),
        (raw(3, bytes(39)), "bad VIDEO: VIDEO: shorter than its header; begin the payload with its 40 bytes"),
        (raw(3, video_payload(32, 1, 1, 4, 2, 16, 1, 2, 0)), "unknown flags; send 0, or 1"),
        (raw(3, video_payload(32, 1, 1, 4, 2, 16, 1, 0, 1)), "unknown flags"),
        (raw(3, video_payload(32, 1, 1, 4, 2, 16, 5, 0, 0)), r"unknown pixel format 5; send 1 \(BGRA\), 2 \(I420\), 3"),
        (raw(3, video_payload(9, 1, 1, 4, 2, 16, 4, 0, 0)), "a stride, with an encoded picture; send stride 0"),
        (raw(3, video_payload(9, 1, 1, 4, 2, 0, 4, 1, 0)), "unknown flags, or"),
        (raw(3, video_payload(9, 1, 1, 4, 2, 0, 4, 2, 1)), "unknown flags, or"),
        (raw(3, video_payload(9, 1, 1, 1, 2, 0, 4, 2, 0)), "width and height"),
        (raw(3, video_payload(32, 1, 1, 4, 2, 15, 1, 0, 0)), "stride shorter than a row; it must be 16 bytes or more"),
        (raw(3, video_payload(31, 1, 1, 4, 2, 16, 1, 0, 0)), "32 bytes of pixels expected, 31 found; send whole rows"),
        (raw(3, video_payload(33, 1, 1, 4, 2, 16, 1, 0, 0)), "32 bytes of pixels expected, 33 found"),
        (raw(3, video_payload(32, 1, 1, 1, 2, 16, 1, 0, 0)), "width and height must be 2 to 16384, not 1x2"),
        (raw(3, video_payload(32, 1, 1, 4, 2**32 - 1, 16, 1, 0, 0)), "width and height"),
        (raw(3, video_payload(18, 1, 1, 3, 2, 6, 2, 0, 0)), "must be even"),
        (raw(3, video_payload(18, 1, 1, 4, 3, 4, 2, 0, 0)), "must be even"),
        (raw(3, video_payload(15, 1, 1, 4, 2, 5, 3, 0, 0)), "must be even"),
        (raw(3, video_payload(6, 1, 1, 4, 2, 2, 3, 0, 0)), "stride shorter than a row"),
        (raw(8, length=49), "RING of 49 bytes is over the limit of 48"),
        (raw(8, bytes(47)), "bad RING: RING: 48 bytes expected, 47 found; send the header"),
        (raw(8, video_payload(8, 1, 1, 4, 2, 16, 4, 0, 0)), "unknown pixel format"),
        (raw(8, video_payload(8, 1, 1, 4, 2, 15, 1, 0, 0)), "stride shorter than a row"),
        (raw(8, video_payload(7, 1, 1, 4, 2, 16, 1, 0, 0) + b"x"), "RING: unknown flags; send 0"),
        (raw(4, bytes(23)), "AUDIO: shorter than its header; begin the payload with its 24 bytes"),
        (raw(4, AUDIO_HEADER.pack(1, 1, 1, 1)), "AUDIO: unknown flags; send 0"),
        (raw(4, AUDIO_HEADER.pack(1, 1, 0, 0)), "AUDIO: channels must be 1 to 2, not 0"),
        (raw(4, AUDIO_HEADER.pack(1, 1, 3, 0)), "AUDIO: channels"),
        (raw(4, AUDIO_HEADER.pack(1, 1, 2, 0) + bytes(6)), "AUDIO: the last sample is not whole; send 2 bytes"),
    ],
)
def test_malformed_bytes_are_named(data: bytes, named: str) -> None:
    with pytest.raises(LinkError, match=named):
        greeted().feed(data)


@pytest.mark.parametrize("kind", [3, 4, 5, 6, 2])
def test_an_engine_says_hello_before_it_may_cost_memory(kind: int) -> None:
    with pytest.raises(LinkError, match="is not expected here"):
        Parser(Sender.ENGINE).feed(raw(kind, length=MAX_VIDEO if kind == 3 else 10))


@pytest.mark.parametrize("kind", [1, 3, 4, 5, 6])
def test_an_adapter_says_welcome_first(kind: int) -> None:
    with pytest.raises(LinkError, match="is not expected here"):
        Parser(Sender.ADAPTER).feed(raw(kind))


def test_goodbye_may_be_the_first_word() -> None:
    assert Parser(Sender.ADAPTER).feed(wire(Bye("full"))) == [Bye("full")]
    assert Parser(Sender.ENGINE).feed(wire(Bye("no display"))) == [Bye("no display")]


@given(st.sampled_from(SIDES), st.data())
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_mutated_bytes_raise_nothing_else(side: tuple[Sender, list[Message]], data: st.DataObject) -> None:
    sender, messages = side
    mutated = bytearray(wire(*messages[:1], *data.draw(st.permutations(messages[1:]))))
    for place in data.draw(st.lists(st.integers(0, min(len(mutated), 600) - 1), max_size=4)):
        mutated[place] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(mutated)))
    parser = Parser(sender)
    with suppress(LinkError):
        parser.feed(mutated[:cut])
        parser.feed(mutated[cut:])


@given(st.binary(max_size=200))
@settings(max_examples=50, deadline=None)
def test_arbitrary_bytes_raise_nothing_else(data: bytes) -> None:
    for prefix in (b"", wire(HELLO), wire(HELLO) + b"ORL1", wire(HELLO) + raw(6, length=len(data))):
        with suppress(LinkError):
            Parser(Sender.ENGINE).feed(prefix + data)


def test_oversized_message_cannot_be_made_or_sent() -> None:
    with pytest.raises(LinkError, match="timestamp_ns does not fit 64 bits; use CLOCK_MONOTONIC"):
        encode(Video(1, -1, 2, 2, 8, PixelFormat.BGRA, bytes(16)))
    with pytest.raises(LinkError, match=r"COMMAND of .* over the limit"):
        encode(Speak("1", 0, (Viseme(0, "sil", 1),) * (4 * MAX_VISEMES), 0))
    with pytest.raises(LinkError, match=r"not JSON compliant.*; use finite numbers"):
        encode(Look(float("nan"), 0))
    with pytest.raises(LinkError, match="AUDIO: over the limit of 65536 bytes; send shorter blocks"):
        Audio(0, 0, 1, bytes(MAX_AUDIO))
    with pytest.raises(LinkError, match=r"VIDEO: over the limit of .*; encode at a lower bit rate"):
        Encoded(0, 0, 4, 2, True, bytes(2**26))
    with pytest.raises(LinkError, match=r"VIDEO: over the limit of .*; send smaller pictures"):
        Video(0, 0, 4096, 4096, 16384, PixelFormat.BGRA, bytes(2**26))


def test_the_sequence_wraps_at_64_bits() -> None:
    header, _ = encode(Audio(2**64 + 5, 1, 1, b""))
    assert AUDIO_HEADER.unpack_from(header, HEADER.size)[0] == 5
