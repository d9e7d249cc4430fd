"""Frames and messages of speech as a stream."""

import json
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.input.credit import AHEAD, CreditReceiver, CreditSender
from openrois_streaming.input.messages import InputError
from openrois_streaming.input.speech import (
    MAX_SPOKEN_TEXT,
    MAX_WORD,
    MAX_WORDS,
    RATES,
    SPEECH_MESSAGE_LIMIT,
    Begin,
    Clear,
    End,
    Finished,
    Frame,
    Granted,
    Refused,
    SpeechMessage,
    SpeechTold,
    Started,
    Starved,
    TimedWord,
    Words,
    is_clear,
    pack_frame,
    parse_frame,
    read_clear,
    read_speech,
    read_told,
)

NUMBERS = st.integers(0, 2**32 - 1)
TIMED = st.lists(st.builds(TimedWord, st.text(min_size=1, max_size=10), st.integers(0, 86_400_000)), max_size=5).map(
    tuple
)
MESSAGES = st.one_of(
    st.builds(Begin, NUMBERS, st.sampled_from(["pcm16", "opus"]), st.sampled_from(RATES), st.text(max_size=20)),
    st.builds(Words, NUMBERS, TIMED, TIMED),
    st.builds(End, NUMBERS),
)
COUNTS = st.integers(0, 2**53)
TOLD = st.one_of(
    st.builds(Started, NUMBERS, st.text(max_size=20)),
    st.builds(Granted, NUMBERS, COUNTS, COUNTS),
    st.builds(Starved, NUMBERS, COUNTS),
    st.builds(Finished, NUMBERS, COUNTS, st.text(max_size=20)),
    st.builds(Refused, NUMBERS, st.text(max_size=20)),
)


def test_a_frame_is_laid_out_as_the_page_says() -> None:
    assert pack_frame(Frame(0x01020304, 5, b"\x10\x20")) == bytes.fromhex("01020304 00000005 1020")


@given(st.builds(Frame, NUMBERS, NUMBERS, st.binary(min_size=1, max_size=SPEECH_MESSAGE_LIMIT - 8)))
def test_a_frame_is_read_as_it_was_written(frame: Frame) -> None:
    assert parse_frame(pack_frame(frame)) == frame


@pytest.mark.parametrize("size", [0, 7, 8, SPEECH_MESSAGE_LIMIT + 1])
def test_a_frame_of_another_size_is_refused(size: int) -> None:
    with pytest.raises(InputError, match=f"9 to 4096 bytes, not {size}"):
        parse_frame(bytes(size))


@given(MESSAGES)
def test_a_message_is_read_as_it_was_written(message: SpeechMessage) -> None:
    assert read_speech(json.dumps(message.to_json())) == message


@given(TOLD)
def test_what_a_body_tells_is_read_as_it_was_written(told: SpeechTold) -> None:
    assert read_told(json.dumps(told.to_json())) == told


def test_what_a_later_body_tells_besides_is_passed_over() -> None:
    assert read_told('{"event": "applause", "utterance": 1}') is None
    assert read_told('{"event": "starved", "utterance": 1, "position": 2, "more": 3}') == Starved(1, 2)


def test_clear_is_told_from_what_an_operator_does() -> None:
    text = json.dumps(Clear(7).to_json())
    assert (is_clear(text), read_clear(text)) == (True, Clear(7))
    assert not is_clear('{"event": "key", "seq": 1, "t": 2, "code": "KeyW", "down": true}')
    with pytest.raises(InputError, match="event"):
        read_clear('{"event": "end", "utterance": 7, "clear": 1}')


def test_the_longest_begin_has_room() -> None:
    begin = Begin(2**32 - 1, "pcm16", 48_000, "ü" * MAX_SPOKEN_TEXT)
    assert read_speech(json.dumps(begin.to_json(), ensure_ascii=False)) == begin


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"utterance": -1}, "utterance"),
        ({"utterance": 2**32}, "utterance"),
        ({"utterance": True}, "utterance"),
        ({"utterance": 1.0}, "utterance"),
        ({"event": "clear"}, "event"),
        ({"event": ["begin"]}, "event"),
        ({"format": "mp3"}, "format"),
        ({"format": ["opus"]}, "format"),
        ({"rate": 44_100}, "rate"),
        ({"rate": 48_000.0}, "rate"),
        ({"rate": "48000"}, "rate"),
        ({"text": 5}, "text"),
        ({"text": "a" * (MAX_SPOKEN_TEXT + 1)}, "text"),
        ({"event": "words", "words": {}}, "words"),
        ({"event": "words", "words": [["a", 1]] * (MAX_WORDS + 1)}, "words"),
        ({"event": "words", "words": ["a"]}, "words"),
        ({"event": "words", "words": [["a"]]}, "words"),
        ({"event": "words", "words": [["", 1]]}, "words"),
        ({"event": "words", "words": [["a" * (MAX_WORD + 1), 1]]}, "words"),
        ({"event": "words", "marks": [["a", -1]]}, "marks"),
        ({"event": "words", "marks": [["a", True]]}, "marks"),
    ],
)
def test_a_wrong_message_is_refused_by_name(wrong: dict[str, Any], named: str) -> None:
    with pytest.raises(InputError, match=named):
        read_speech(json.dumps({"event": "begin", "utterance": 1, "format": "opus", "rate": 48_000, **wrong}))


@pytest.mark.parametrize(
    "text", ["", "[]", "5", "{", "[" * 4000, '{"event": "end", "utterance": 1}' + " " * 4096, "ü" * 3000]
)
def test_what_is_no_message_is_refused(text: str) -> None:
    for read in (read_speech, read_clear, read_told):
        with pytest.raises(InputError, match="message"):
            read(text)


@given(st.text(max_size=200))
def test_any_text_is_read_or_refused(text: str) -> None:
    for read in (read_speech, read_clear, read_told):
        with suppress(InputError):
            read(text)


def test_a_second_may_be_sent_before_any_credit_and_no_more_than_that() -> None:
    sender, receiver = CreditSender(16_000), CreditReceiver(16_000)
    assert sender.room == AHEAD * 16_000
    sender.send(16_000)
    receiver.receive(16_000)
    assert sender.room == 0
    with pytest.raises(InputError, match="16001 samples were sent where 16000 were granted"):
        receiver.receive(1)
    assert receiver.received == 16_000


def test_credit_grows_with_what_is_played_and_is_told_in_steps() -> None:
    sender, receiver = CreditSender(24_000), CreditReceiver(24_000)
    assert receiver.grant(2_399) is None
    granted = receiver.grant(2_400)
    assert granted == 26_400
    assert receiver.grant(2_401) is None
    sender.granted(granted, 2_400)
    assert (sender.room, sender.played) == (26_400, 2_400)
    sender.granted(10, 5)
    assert (sender.room, sender.played) == (26_400, 2_400)


@given(st.lists(st.integers(1, 5_000), max_size=60), st.randoms())
def test_a_sender_that_keeps_to_its_credit_is_never_refused(pushes: list[int], random: Any) -> None:
    sender, receiver, played = CreditSender(16_000), CreditReceiver(16_000), 0
    for push in pushes:
        count = min(push, sender.room)
        sender.send(count)
        receiver.receive(count)
        played = random.randint(played, receiver.received)
        granted = receiver.grant(played)
        if granted is not None:
            sender.granted(granted, played)
        assert receiver.received - played <= AHEAD * 16_000
