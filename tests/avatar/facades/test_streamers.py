"""The signaling servers of game engines: whole conversations, message by message."""

import json
from pathlib import Path
from typing import Any

import pytest
from openrois_avatar.facades.messages.reading import ProtocolError
from openrois_avatar.facades.streamer import Found, Heard, NoRoom, Streamer
from openrois_avatar.facades.unity import CONNECTIONS_LIMIT, UnitySender
from openrois_avatar.facades.unreal import UnrealStreamer
from openrois_signaling.messages import IceServer

CONVERSATIONS = Path(__file__).parent / "conversations"


def recorded() -> list[Any]:
    return [
        pytest.param(file.stem, conversation, id=f"{file.stem}: {conversation['name']}")
        for file in sorted(CONVERSATIONS.glob("*.json"))
        for conversation in json.loads(file.read_text())
    ]


class Conversation:
    """Plays a recorded conversation: the engine's part is said, everything else has to come."""

    def __init__(self, protocol: str) -> None:
        self.said: list[dict[str, Any]] = []
        self.heard: list[Heard] = []
        self.refused = ""

        def send(text: str) -> None:
            self.said.append(json.loads(text))

        self.streamer: Streamer = (
            UnrealStreamer(send, self.heard.append)
            if protocol == "unreal"
            else UnitySender(send, self.heard.append, lambda: 5.0)
        )
        self.streamer.begin()

    def step(self, step: dict[str, Any]) -> None:
        match step:
            case {"server": expected}:
                assert self.said.pop(0) == expected
            case {"heard": [kind, *members]}:
                heard = self.heard.pop(0)
                assert [type(heard).__name__, *(getattr(heard, name) for name in heard.__slots__)] == [kind, *members]
            case {"refused": why}:
                assert why in self.refused
                self.refused = ""
            case _:
                self.nothing_is_left()
                self.act(step)

    def nothing_is_left(self) -> None:
        assert [*self.said, *self.heard] == []
        assert self.refused == ""

    def act(self, step: dict[str, Any]) -> None:
        match step:
            case {"engine": message}:
                try:
                    self.streamer.handle_message(json.dumps(message))
                except ProtocolError as error:
                    self.refused = str(error)
            case {"invite": player_id, "full": True}:
                assert not self.streamer.has_room
                with pytest.raises(NoRoom):
                    self.streamer.invite(player_id, ())
            case {"invite": player_id}:
                servers = [IceServer.model_validate(each) for each in step.get("ice_servers", ())]
                assert self.streamer.has_room
                self.streamer.invite(player_id, servers)
            case {"answer": [player_id, sdp]}:
                self.streamer.send_answer(player_id, sdp)
            case {"find": members}:
                self.streamer.send_candidate(Found(*members))
            case {"dismiss": player_id}:
                self.streamer.dismiss(player_id)


@pytest.mark.parametrize(("protocol", "conversation"), recorded())
def test_a_recorded_conversation(protocol: str, conversation: dict[str, Any]) -> None:
    played = Conversation(protocol)
    if "greeted" in conversation:
        played.streamer.handle_message(json.dumps({"type": "endpointId", "id": conversation["greeted"]}))
        assert played.streamer.name == conversation["greeted"]
        played.said.clear()
    for step in conversation["steps"]:
        played.step(step)
    played.nothing_is_left()


def test_streamer_is_ready_after_it_has_identified_itself() -> None:
    streamer = Conversation("unreal").streamer
    assert not streamer.ready
    streamer.handle_message('{"type": "endpointId", "id": "U"}')
    assert streamer.ready


def test_a_sender_is_ready_when_it_has_asked_for_a_connection() -> None:
    sender = Conversation("unity").streamer
    assert not sender.ready
    sender.handle_message('{"type": "connect", "connectionId": "a"}')
    assert sender.ready


def test_the_connections_of_a_sender_are_bounded() -> None:
    played = Conversation("unity")
    for number in range(CONNECTIONS_LIMIT + 1):
        played.streamer.handle_message(json.dumps({"type": "connect", "connectionId": str(number)}))
    assert [each["type"] for each in played.said] == ["error"]
