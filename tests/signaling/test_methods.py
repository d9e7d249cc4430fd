from typing import Any

import pytest
from openrois_signaling import (
    Handler,
    IceServer,
    IceServers,
    InvalidParams,
    Refused,
    Relay,
    TooLong,
    signaling_methods,
)
from openrois_signaling.messages import CANDIDATE_LIMIT, SDP_LIMIT
from openrois_signaling.methods import ERRORS_LIMIT, PATH_LIMIT
from openrois_signaling.relay import Upward

ANSWER = {"peer_id": "p", "generation": 1, "sdp": "v=0"}
CANDIDATE = {"peer_id": "p", "generation": 1, "candidate": "candidate:1", "sdp_mid": "0", "sdp_m_line_index": 0}


@pytest.fixture
def forwarded() -> list[Upward]:
    return []


@pytest.fixture
def table(forwarded: list[Upward]) -> dict[str, Handler]:
    async def forward(engine: str, message: Upward) -> None:
        forwarded.append(message)

    relay: Relay[str, str] = Relay(forward, lambda: 0.0)
    relay.register("p", "alice", "avatar")
    turn = IceServer(urls=("turn:turn.example.org",), username="alice", credential="secret")
    stun = IceServer(urls=("stun:stun.example.org",))
    return signaling_methods(relay, "alice", lambda: IceServers((stun, turn), 600))


def test_it_serves_what_an_application_may_call(table: dict[str, Handler]) -> None:
    assert set(table) == {"signaling.answer", "signaling.candidate", "signaling.restart", "signaling.ice_servers"}


@pytest.mark.parametrize(
    ("method", "params"),
    [
        ("signaling.answer", ANSWER),
        ("signaling.candidate", CANDIDATE),
        ("signaling.candidate", {"peer_id": "p", "generation": 1, "candidate": None}),
        ("signaling.restart", {"peer_id": "p"}),
    ],
)
async def test_a_message_passes_on_as_it_came(
    table: dict[str, Handler], forwarded: list[Upward], method: str, params: dict[str, Any]
) -> None:
    assert await table[method](params) == {"return_code": "OK"}
    assert [message.wire() for message in forwarded] == [params]
    with pytest.raises(Refused, match="there is no such peer connection") as refusal:
        await table[method]({**params, "peer_id": "q"})
    assert refusal.value.return_code == "UNSUPPORTED"


@pytest.mark.parametrize(
    ("method", "params"),
    [
        ("signaling.answer", {**ANSWER, "sdp": "x" * (SDP_LIMIT + 1)}),
        ("signaling.candidate", {**CANDIDATE, "candidate": "x" * (CANDIDATE_LIMIT + 1)}),
        ("signaling.restart", {"peer_id": "x" * 1000}),
    ],
)
async def test_what_is_too_large_is_a_bad_parameter(
    table: dict[str, Handler], forwarded: list[Upward], method: str, params: dict[str, Any]
) -> None:
    with pytest.raises(TooLong, match=r"^(sdp|candidate|peer_id): more than \d+ bytes$") as refusal:
        await table[method](params)
    assert refusal.value.return_code == "BAD_PARAMETER"
    assert forwarded == []


@pytest.mark.parametrize(
    ("method", "params", "paths"),
    [
        ("signaling.answer", {}, ["peer_id", "generation", "sdp"]),
        ("signaling.answer", {**ANSWER, "generation": True}, ["generation"]),
        ("signaling.answer", {**ANSWER, "sdp": "\ud800"}, ["sdp"]),
        ("signaling.answer", {**ANSWER, "type": "answer"}, ["type"]),
        ("signaling.answer", {"peer_id": 1, "generation": 1, "sdp": "x" * (SDP_LIMIT + 1)}, ["peer_id", "sdp"]),
        ("signaling.candidate", {"peer_id": "p", "generation": 1, "candidate": "c"}, [""]),
        ("signaling.restart", {"peer_id": ""}, ["peer_id"]),
        ("signaling.ice_servers", {"urls": []}, ["urls"]),
    ],
)
async def test_params_of_another_shape_are_refused_with_paths(
    table: dict[str, Handler], forwarded: list[Upward], method: str, params: dict[str, Any], paths: list[str]
) -> None:
    with pytest.raises(InvalidParams) as refusal:
        await table[method](params)
    assert [error["path"] for error in refusal.value.errors] == paths
    assert all(set(error) == {"path", "message"} and error["message"] for error in refusal.value.errors)
    assert forwarded == []


async def test_a_refusal_is_bounded_and_does_not_repeat_what_was_sent(table: dict[str, Handler]) -> None:
    unknown = {f"{number:03}" + "x" * 1000: "password" for number in range(100)}
    with pytest.raises(InvalidParams) as refusal:
        await table["signaling.restart"]({"peer_id": "p", **unknown})
    assert len(refusal.value.errors) == ERRORS_LIMIT
    assert max(len(error["path"]) for error in refusal.value.errors) == PATH_LIMIT
    assert "password" not in str(refusal.value)


async def test_ice_servers_come_with_the_time_they_hold(table: dict[str, Handler]) -> None:
    assert await table["signaling.ice_servers"]({}) == {
        "return_code": "OK",
        "ice_servers": [
            {"urls": ["stun:stun.example.org"]},
            {"urls": ["turn:turn.example.org"], "username": "alice", "credential": "secret"},
        ],
        "ttl": 600,
    }
