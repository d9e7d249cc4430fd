"""What a streamer answers to one player."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_avatar.pixel_streaming.conversation import AT_ONCE, MALFORMED_LIMIT, Conversation
from openrois_avatar.pixel_streaming.player_input import PlayerInput
from openrois_avatar.pixel_streaming.protocol import FROM_STREAMER, Message, written
from openrois_streaming.input.messages import Held, Key
from openrois_streaming.input.messages import Message as InputMessage

NAMES = {layout.id: name for name, layout in FROM_STREAMER.items()}


class Stage:
    def __init__(self) -> None:
        self.now = 0.0
        self.sent: list[bytes] = []
        self.did: list[object] = []
        self.conversation = Conversation(self, lambda: self.now, lambda: 1000.0 + self.now)

    def send(self, message: bytes) -> None:
        self.sent.append(message)

    def show_anew(self) -> None:
        self.did.append("show anew")

    def play(self, on: bool) -> None:
        self.did.append(on)

    def operate(self, message: InputMessage, player_input: PlayerInput) -> None:
        self.did.append((message, player_input.held))

    def says(self, name: str, *values: Any) -> list[tuple[str, Any]]:
        before = len(self.sent)
        self.conversation.handle_message(written(Message(name, values)))
        return [told(each) for each in self.sent[before:]]


def told(message: bytes) -> tuple[str, Any]:
    name = NAMES[message[0]]
    if "string" in FROM_STREAMER[name].structure:
        return name, json.loads(message[1:].decode("utf-16-le"))
    return name, message[1:]


@pytest.fixture
def stage() -> Stage:
    return Stage()


def test_conversation_begins_with_tables_and_ownership(stage: Stage) -> None:
    stage.conversation.own(True)
    assert stage.sent == []
    stage.conversation.opened()
    assert [told(each)[0] for each in stage.sent] == ["Protocol", "Protocol", "InputControlOwnership"]
    assert stage.sent[-1] == b"\x0c\x01"
    stage.conversation.own(False)
    assert stage.sent[-1] == b"\x0c\x00"


def test_questions_are_answered(stage: Stage) -> None:
    assert stage.says("RequestQualityControl") == [("QualityControlOwnership", b"\0")]
    ((name, settings),) = stage.says("RequestInitialSettings")
    assert name == "InitialSettings"
    assert settings["ConfigOptions"] == {"DefaultToHover": True}
    times = {"ReceiptTimeMs": 1_000_000, "TransmissionTimeMs": 1_000_000}
    assert stage.says("LatencyTest", "{}") == [("LatencyTest", times)]
    assert stage.says("TestEcho") == [("TestEcho", b"")]
    assert [stage.says("GamepadConnected") for _ in range(5)] == [
        *([("GamepadResponse", {"controllerId": number})] for number in range(4)),
        [],
    ]


def test_the_stage_does_what_is_asked(stage: Stage) -> None:
    for name in ("IFrameRequest", "StopStreaming", "StartStreaming"):
        stage.says(name)
    assert stage.did == ["show anew", False, True]
    stage.says("KeyDown", 87, 0)
    assert stage.did[-1] == (Key(1, 0.0, "KeyW", True), Held(frozenset({"KeyW"})))
    stage.says("UIInteraction", '{"wave": true}')
    assert len(stage.did) == 4
    assert stage.conversation.figures.read == 5


def test_unknown_and_malformed_messages_are_counted_and_reading_ends_after_many(stage: Stage) -> None:
    stage.conversation.handle_message(b"\xc8")
    stage.conversation.handle_message("a text")
    for _ in range(MALFORMED_LIMIT):
        stage.conversation.handle_message(b"\x3c")
    stage.says("IFrameRequest")
    figures = stage.conversation.figures
    assert (figures.read, figures.unknown, figures.malformed, stage.did) == (0, 1, MALFORMED_LIMIT, [])


def test_excess_messages_are_dropped_until_time_has_passed(stage: Stage) -> None:
    for _ in range(AT_ONCE + 10):
        stage.says("IFrameRequest")
    assert (stage.conversation.figures.excess, len(stage.did)) == (10, AT_ONCE)
    stage.now = 1.0
    stage.says("IFrameRequest")
    assert len(stage.did) == AT_ONCE + 1


@given(st.lists(st.binary(max_size=40) | st.text(max_size=5), max_size=60))
def test_whatever_comes_raises_nothing(messages: list[str | bytes]) -> None:
    stage = Stage()
    stage.conversation.opened()
    for message in messages:
        stage.conversation.handle_message(message)
