"""The messages of Pixel Streaming's data channel: bytes as Epic's front-end packs them, and whatever else comes."""

import json
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_avatar.pixel_streaming.protocol import (
    FROM_STREAMER,
    MESSAGE_LIMIT,
    TO_STREAMER,
    Message,
    MessageError,
    flag,
    read,
    tables,
    text,
    written,
)

PACKED = [
    ("00", Message("IFrameRequest")),
    ("3c 57 01", Message("KeyDown", (87, 1))),
    ("3d 26", Message("KeyUp", (38,))),
    ("4a ff7f 0080 ffff 0100", Message("MouseMove", (32767, 32768, -1, 1))),
    ("4b 88ff 0000 ffff", Message("MouseWheel", (-120, 0, 65535))),
    ("50 01 0100 0200 03 ff 01", Message("TouchStart", (1, 1, 2, 3, 255, 1))),
    ("51 02 0100 0200 03 ff 01 0500 0600 07 08 00", Message("TouchEnd", (2, 1, 2, 3, 255, 1, 5, 6, 7, 8, 0))),
    ("5c 00 02" + struct.pack("<d", -0.5).hex(), Message("GamepadAnalog", (0, 2, -0.5))),
    ("06 0200 6100 fc00", Message("LatencyTest", ("aü",))),
]


@pytest.mark.parametrize(("packed", "message"), PACKED)
def test_messages_are_read_and_written_as_the_front_end_packs_them(packed: str, message: Message) -> None:
    assert read(bytes.fromhex(packed)) == message
    assert written(message) == bytes.fromhex(packed)


@pytest.mark.parametrize(
    ("packed", "problem"),
    [
        ("", "1 to 4096 bytes, not 0"),
        ("00" * (MESSAGE_LIMIT + 1), "not 4097"),
        ("3c 57", "KeyDown: it ends within uint8"),
        ("3d 57 00", "KeyUp: 1 bytes too many"),
        ("06", "LatencyTest: it ends within string"),
        ("06 0200 6100", "LatencyTest: its text ends too early"),
        ("50", "TouchStart: it ends within uint8"),
        ("50 ff", "TouchStart: must have at most 64 fields"),
    ],
)
def test_fault_is_named(packed: str, problem: str) -> None:
    with pytest.raises(MessageError, match=problem):
        read(bytes.fromhex(packed))


def test_numbers_that_are_not_known_are_no_fault() -> None:
    assert read(b"\xc8whatever") is None


def test_message_with_wrong_values_is_not_written() -> None:
    with pytest.raises(MessageError, match="KeyUp: must have 1 fields, not 2"):
        written(Message("KeyUp", (1, 2)))


def test_a_streamer_says_yes_or_no_and_texts_without_their_length() -> None:
    assert (flag("InputControlOwnership", True), flag("TestEcho", True)) == (b"\x0c\x01", b"\x0b")
    assert text("Response", "ü") == b"\x01\xfc\x00"


def test_the_tables_are_told_for_both_directions() -> None:
    told = [json.loads(table[1:].decode("utf-16-le")) for table in tables()]
    assert [table.pop("Direction") for table in told] == [0, 1]
    assert told[0]["KeyDown"] == {"id": 60, "structure": ["uint8", "uint8"]}
    assert [len(each) for each in told] == [len(TO_STREAMER), len(FROM_STREAMER)]


@given(
    st.binary(max_size=64)
    | st.integers(0, 94).flatmap(lambda first: st.binary(max_size=20).map(bytes([first]).__add__))
)
def test_whatever_is_read_is_written_as_it_came(data: bytes) -> None:
    try:
        message = read(data)
    except MessageError:
        return
    if message is not None:
        again = read(written(message))
        assert again is not None
        assert again == message or "GamepadAnalog" in again.name
