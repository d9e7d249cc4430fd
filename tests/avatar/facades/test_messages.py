"""The signaling messages of game engines are read as they are meant, and nothing else is."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_avatar.facades.messages import pixel_streaming as unreal
from openrois_avatar.facades.messages import render_streaming as unity
from openrois_avatar.facades.messages.reading import MESSAGE_LIMIT, ProtocolError, Said, Unknown, Vocabulary
from openrois_signaling.messages import IceServer

OFFER = {"type": "offer", "playerId": "7", "sdp": "v=0"}
CANDIDATE = {"candidate": "candidate:1", "sdpMid": "0", "sdpMLineIndex": 0, "usernameFragment": "u"}
STREAMER: list[tuple[dict[str, Any], Said]] = [
    ({"type": "endpointId", "id": "Unreal"}, unreal.EndpointId(id="Unreal")),
    (OFFER | {"multiplex": True}, unreal.Offer(player_id="7", sdp="v=0")),
    (OFFER | {"type": "answer", "minBitrateBps": 1}, unreal.Answer(player_id="7", sdp="v=0")),
    (
        {"type": "iceCandidate", "playerId": "7", "candidate": CANDIDATE},
        unreal.IceCandidate(
            player_id="7",
            candidate=unreal.RtcCandidate(
                candidate="candidate:1", sdp_mid="0", sdp_m_line_index=0, username_fragment="u"
            ),
        ),
    ),
    ({"type": "disconnectPlayer", "playerId": "7"}, unreal.DisconnectPlayer(player_id="7")),
    ({"type": "ping", "time": 5}, unreal.Ping(time=5)),
    ({"type": "pong", "time": 5.5}, unreal.Pong(time=5.5)),
]
SENDER: list[tuple[dict[str, Any], Said]] = [
    ({"type": "connect", "connectionId": "a"}, unity.Connect(connection_id="a")),
    ({"type": "disconnect", "connectionId": "a"}, unity.Disconnect(connection_id="a")),
    (
        {"from": "a", "to": "", "type": "offer", "data": {"connectionId": "a", "sdp": "v=0", "type": "offer"}},
        unity.Offer(data=unity.Description(sdp="v=0", connection_id="a"), from_="a"),
    ),
    (
        {"from": "a", "type": "answer", "data": {"connectionId": "", "sdp": "v=0"}},
        unity.Answer(data=unity.Description(sdp="v=0", connection_id=""), from_="a"),
    ),
    (
        {"type": "candidate", "data": {"connectionId": "a", "candidate": "c", "sdpMLineIndex": 1, "sdpMid": "1"}},
        unity.Candidate(data=unity.Found(candidate="c", sdp_mid="1", sdp_m_line_index=1, connection_id="a")),
    ),
]


@pytest.mark.parametrize(("wire", "message"), STREAMER)
def test_messages_of_a_streamer_are_read(wire: dict[str, Any], message: Said) -> None:
    assert unreal.STREAMER_SAYS.read(json.dumps(wire)) == message


@pytest.mark.parametrize(("wire", "message"), SENDER)
def test_messages_of_a_sender_are_read(wire: dict[str, Any], message: Said) -> None:
    assert unity.SENDER_SAYS.read(json.dumps(wire)) == message
    if not isinstance(message, unity.Connect | unity.Disconnect):
        assert message.connection_id == "a"


SERVER = [
    unreal.Config(
        peer_connection_options=unreal.PeerConnectionOptions(ice_servers=(IceServer(urls=("stun:stun.example.org",)),))
    ),
    unreal.Identify(),
    unreal.EndpointIdConfirm(committed_id="Unreal"),
    unreal.PlayerConnected(player_id="7", data_channel=False),
    unreal.PlayerDisconnected(player_id="7"),
    unreal.LayerPreference(player_id="7", spatial_layer=0, temporal_layer=1),
    unreal.Pong(time=1),
]


@pytest.mark.parametrize("message", SERVER, ids=lambda message: message.type)
def test_messages_to_a_streamer_are_as_it_reads_them(message: Said) -> None:
    assert unreal.SERVER_SAYS.read(message.text()) == message


def test_the_members_have_the_names_of_their_protocol() -> None:
    assert json.loads(SERVER[0].text()) == {
        "type": "config",
        "peerConnectionOptions": {"iceServers": [{"urls": ["stun:stun.example.org"]}]},
    }
    assert json.loads(SERVER[3].text()) == {
        "type": "playerConnected",
        "playerId": "7",
        "dataChannel": False,
        "sfu": False,
        "sendOffer": True,
    }
    found = unity.Found(candidate="c", sdp_mid="0", sdp_m_line_index=0, datetime=3)
    assert json.loads(unity.Candidate(data=found, from_="a").text()) == {
        "type": "candidate",
        "from": "a",
        "to": "",
        "data": {"candidate": "c", "sdpMid": "0", "sdpMLineIndex": 0, "datetime": 3},
    }


def test_ice_servers_are_read_as_w3c_allows_them() -> None:
    servers = [
        {"urls": "stun:stun.example.org"},
        {"urls": ["turn:a.example.org", "turn:b.example.org"], "username": "u", "credential": "c"},
        {"urls": "turn:a.example.org", "username": "u", "credential": "c", "credentialType": "password"},
    ]
    config = unreal.SERVER_SAYS.read(json.dumps({"type": "config", "peerConnectionOptions": {"iceServers": servers}}))
    assert isinstance(config, unreal.Config)
    assert config.peer_connection_options.ice_servers == (
        IceServer(urls=("stun:stun.example.org",)),
        IceServer(urls=("turn:a.example.org", "turn:b.example.org"), username="u", credential="c"),
        IceServer(urls=("turn:a.example.org",), username="u", credential="c"),
    )


@pytest.mark.parametrize(
    "server", ["stun:a.example.org", {}, {"urls": ""}, {"urls": []}, {"urls": 1}, {"url": "stun:a"}]
)
def test_malformed_ice_server_is_refused(server: object) -> None:
    with pytest.raises(ProtocolError, match="config: peerConnectionOptions"):
        unreal.SERVER_SAYS.read(json.dumps({"type": "config", "peerConnectionOptions": {"iceServers": [server]}}))


def test_messages_to_a_sender_are_as_it_reads_them() -> None:
    for message in (unity.Connected(connection_id="a", polite=True), unity.Failure(message="no")):
        assert unity.SERVER_SAYS.read(message.text()) == message


def test_a_type_that_is_not_known_is_no_fault() -> None:
    assert unreal.STREAMER_SAYS.read('{"type": "stats", "data": 1}') == Unknown("stats")


@pytest.mark.parametrize(
    ("vocabulary", "text", "why"),
    [
        (unreal.STREAMER_SAYS, "{", "no message with a type"),
        (unreal.STREAMER_SAYS, "[]", "no message with a type"),
        (unreal.STREAMER_SAYS, '{"type": 1}', "no message with a type: type"),
        (unreal.STREAMER_SAYS, '{"type": "offer", "sdp": "v=0"}', "offer: playerId"),
        (unreal.STREAMER_SAYS, '{"type": "ping", "time": "soon"}', "ping: time"),
        (unreal.STREAMER_SAYS, '"' + "x" * MESSAGE_LIMIT + '"', "more than"),
        (unity.SENDER_SAYS, '{"type": "offer", "data": {"sdp": "v=0"}}', "neither data.connectionId nor from"),
        (unity.SENDER_SAYS, '{"type": "connect", "connectionId": ""}', "connect: connectionId"),
    ],
)
def test_fault_is_named(vocabulary: Vocabulary[Any], text: str, why: str) -> None:
    with pytest.raises(ProtocolError, match=why) as refused:
        vocabulary.read(text)
    assert len(str(refused.value)) < 300


LEAF = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=9)
INNER = st.sampled_from(["connectionId", "sdp", "candidate", "sdpMid", "sdpMLineIndex"])
ANYTHING = LEAF | st.lists(LEAF, max_size=2) | st.dictionaries(INNER, LEAF, max_size=3)
MEMBERS = sorted({key for wire, _ in [*STREAMER, *SENDER] for key in wire if key != "type"})
TYPES = sorted({wire["type"] for wire, _ in [*STREAMER, *SENDER]})


@given(st.sampled_from(TYPES), st.dictionaries(st.sampled_from(MEMBERS), ANYTHING))
def test_any_members_are_read_or_refused(name: str, members: dict[str, Any]) -> None:
    text = json.dumps({"type": name, **members})
    for vocabulary in (unreal.STREAMER_SAYS, unity.SENDER_SAYS, unreal.SERVER_SAYS, unity.SERVER_SAYS):
        try:
            found = vocabulary.read(text)
        except ProtocolError:
            continue
        assert isinstance(found, Said | Unknown)


@given(st.text(max_size=200) | ANYTHING.map(json.dumps))
def test_any_text_is_read_or_refused(text: str) -> None:
    for vocabulary in (unreal.STREAMER_SAYS, unity.SENDER_SAYS):
        try:
            vocabulary.read(text)
        except ProtocolError:
            continue
