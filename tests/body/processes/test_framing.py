import pytest
from openrois_body.processes.framing import (
    HEADER,
    MAX_BODY,
    MAX_SOUND,
    FramingError,
    decode_body,
    decode_header,
    encode,
)


def test_a_message_is_two_lengths_a_body_and_sound() -> None:
    message = encode({"a": "ä"}, b"\1\2\3")
    lengths = decode_header(message[: HEADER.size])
    assert len(message) == HEADER.size + lengths.body + lengths.sound
    assert decode_body(message[HEADER.size : HEADER.size + lengths.body]) == {"a": "ä"}
    assert message[-lengths.sound :] == b"\1\2\3"


@pytest.mark.parametrize(("body", "sound"), [(MAX_BODY + 1, 0), (0, MAX_SOUND + 1), (2**32 - 1, 2**32 - 1)])
def test_lengths_are_limited(body: int, sound: int) -> None:
    assert decode_header(HEADER.pack(MAX_BODY, MAX_SOUND)) == (MAX_BODY, MAX_SOUND)
    with pytest.raises(FramingError, match="bytes"):
        decode_header(HEADER.pack(body, sound))


@pytest.mark.parametrize("text", [b"", b"{", b"\xff", b"[]", b"1"])
def test_a_body_is_a_json_object(text: bytes) -> None:
    with pytest.raises(FramingError, match="not"):
        decode_body(text)
