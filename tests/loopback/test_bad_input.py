"""Whatever is sent over the real sockets gets the specified answer, and everybody else is none the wiser."""

import asyncio
import json
import re
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import suppress
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from tests.support.black_box import (
    H264,
    VIDEO,
    Application,
    Message,
    Refused,
    application,
    encoding_parameters,
    without_candidates,
)
from tests.support.demo import Demo, Watcher, watching

pytestmark = pytest.mark.media

HOST = "candidate:1 1 udp 2130706431 192.0.2.1 50000 typ host"
UNKNOWN = "avatar/00000000000000000000000000000000"


@pytest.fixture(scope="module")
def bystander(demo: Demo) -> Iterator[Watcher]:
    """Viewer in a process of its own that watches all the time."""
    with watching(demo.url) as watcher:
        yield watcher


@pytest.fixture(autouse=True)
def nobody_else_notices(bystander: Watcher) -> Iterator[None]:
    yield
    bystander.wait(1)
    # Whatever hangs takes longer; what is slow is found elsewhere: a busy machine alone has been seen to take 4 s.
    assert bystander.longest_gap() < 10


@pytest.fixture
async def app(demo: Demo) -> AsyncIterator[Application]:
    """An application that can be used as before when a test is through with it."""
    async with application(demo.url) as connected:
        await connected.hello()
        yield connected
        assert VIDEO in (await connected.ask("rois.system.get_profile"))["component_profiles"]


@pytest.fixture
async def other(demo: Demo) -> AsyncIterator[Application]:
    async with application(demo.url) as connected:
        yield connected


def request(**members: Any) -> str:
    return json.dumps({"jsonrpc": "2.0", "id": 7, "method": "rois.system.connect", "params": {}} | members)


@pytest.mark.parametrize(
    ("text", "code", "answered_as"),
    [
        ("{", -32700, None),
        ("", -32700, None),
        ("NaN", -32700, None),
        ("[" * 20_000, -32700, None),
        (f'{{"id": {"9" * 5_000}}}', -32700, None),
        ("[]", -32600, None),
        (f"[{request()}]", -32600, None),
        (request(id=True), -32600, None),
        (request(id={}), -32600, None),
        (request(jsonrpc="1.0"), -32600, 7),
        (request(method=5), -32600, 7),
        (request(method="rois.system.reboot"), -32601, 7),
        (request(method="rois.stream.rewind_stream"), -32601, 7),
        (request(method="openrois.client_gone"), -32601, 7),
        (request(params=[]), -32602, 7),
        (request(params={"now": True}), -32602, 7),
        (request(method="rois.command.bind"), -32602, 7),
        (request(method="rois.stream.connect_stream", params={"component_ref": 5}), -32602, 7),
        (request(method="rois.stream.connect_stream", params={"component_ref": VIDEO, "client_id": "x"}), -32602, 7),
        (request(method="rois.stream.suspend_stream", params={"stream_id": None}), -32602, 7),
        (request(method="signaling.answer", params={"peer_id": UNKNOWN, "generation": "1", "sdp": "v"}), -32602, 7),
        (request(method="signaling.candidate", params={"peer_id": UNKNOWN, "generation": 1}), -32602, 7),
        (request(method="signaling.restart", params={"peer_id": ""}), -32602, 7),
        (request(method="signaling.ice_servers", params={"all": True}), -32602, 7),
    ],
)
async def test_a_broken_message_is_answered_with_the_error_of_the_standard(
    app: Application, text: str, code: int, answered_as: int | None
) -> None:
    answer = await app.exchange(text, answered_as)
    assert answer["error"]["code"] == code
    assert answer["id"] == answered_as
    if code == -32602:
        problems = answer["error"]["data"]
        assert problems
        assert all(set(each) == {"path", "message"} for each in problems)


@pytest.mark.parametrize(
    ("message", "code"), [(b"\x00", 1003), (request(id="x" * 10_000_000), 1009), (request(id="x" * (64 << 10)), 1009)]
)
async def test_a_message_that_cannot_be_taken_ends_its_own_connection_only(
    demo: Demo, message: str | bytes, code: int
) -> None:
    async with connect(demo.url, compression=None) as connection, asyncio.timeout(60):
        with suppress(ConnectionClosed):  # it may end before all is sent
            await connection.send(message)
        await connection.wait_closed()
    assert connection.close_code == code


async def test_a_component_that_is_not_there_has_no_streams(app: Application) -> None:
    for component_ref in (
        "avatar/teleporter",
        "robot/video_streaming",
        "video_streaming",
        "",
        "avatar/system_info",
    ):
        answer = await app.ask("rois.stream.connect_stream", component_ref=component_ref)
        assert answer == {"return_code": "UNSUPPORTED", "stream_id": ""}


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("H264", "BAD_PARAMETER"),
        ('"H264"', "BAD_PARAMETER"),
        ("[" * 20_000, "BAD_PARAMETER"),
        ('{"codecs": "video/H264"}', "BAD_PARAMETER"),
        ('{"codecs": [264]}', "BAD_PARAMETER"),
        (json.dumps({"codecs": ["x"] * 33}), "BAD_PARAMETER"),
        ('{"codecs": []}', "UNSUPPORTED"),
        ('{"codecs": ["video/AV1", "audio/opus"]}', "UNSUPPORTED"),
    ],
)
async def test_encoding_parameters_that_cannot_be_met_are_refused(app: Application, text: str, code: str) -> None:
    answer = await app.ask("rois.stream.connect_stream", component_ref=VIDEO, parameters=[encoding_parameters(text)])
    assert answer == {"return_code": code, "stream_id": ""}
    assert not app.told("signaling.offer")


async def test_streams_of_another_client_look_absent(app: Application, other: Application) -> None:
    stream_id = await app.play(VIDEO, H264)
    peer = app.peer_of(stream_id)
    peer_id, generation = peer.offers[-1]["peer_id"], peer.offers[-1]["generation"]
    sdp, _ = without_candidates(peer.connection.localDescription.sdp)
    for stream, its_peer in ((stream_id, peer_id), (UNKNOWN, UNKNOWN), ("robot/1", "robot/1"), ("x", "x")):
        about: Message = {"peer_id": its_peer, "generation": generation}
        for verb in ("suspend", "resume", "disconnect"):
            assert await other.act(verb, stream) == "UNSUPPORTED"
        answers = [
            await other.ask("rois.stream.query_stream_status", stream_id=stream),
            await other.ask("signaling.answer", **about, sdp=sdp),
            await other.ask("signaling.candidate", **about, candidate=HOST, sdp_mid="0"),
            await other.ask("signaling.restart", peer_id=its_peer),
        ]
        assert [answer["return_code"] for answer in answers] == ["UNSUPPORTED"] * 4
    await app.pictures(stream_id, 3)
    assert app.statuses(stream_id) == ["NOT_RUNNING", "RUNNING"]


DAMAGES: dict[str, Callable[[str], str]] = {
    "no SDP": lambda sdp: "no SDP at all",
    "no text": lambda sdp: "\x00\xff",
    "half of it": lambda sdp: sdp[: len(sdp) // 2],
    "rejected section": lambda sdp: re.sub(r"m=video \d+", "m=video 0", sdp),
    "other kind": lambda sdp: sdp.replace("m=video", "m=audio"),
    "other direction": lambda sdp: sdp.replace("a=recvonly", "a=sendrecv"),
    "no role": lambda sdp: sdp.replace("a=setup:active", "a=setup:actpass"),
    "no fingerprint": lambda sdp: "".join(line for line in sdp.splitlines(True) if "fingerprint" not in line),
    "one section more": lambda sdp: sdp + sdp[sdp.index("m=") :],
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES.keys())
async def test_an_answer_that_cannot_be_used_ends_its_peer_connection_with_a_reason(
    app: Application, damage: Callable[[str], str]
) -> None:
    app.answers = False
    stream_id = await app.connect_stream(VIDEO, H264)
    offer = await first_offer(app)
    answer = damage(await app.described(offer))
    result = await app.ask("signaling.answer", peer_id=offer["peer_id"], generation=1, sdp=answer)
    assert result == {"return_code": "BAD_PARAMETER"}
    [bye] = await app.news.until(lambda: app.told("signaling.bye"))
    assert bye["peer_id"] == offer["peer_id"]
    assert bye["reason"]
    await app.until_status(stream_id, "NOT_CONNECTED")
    assert await app.act("resume", stream_id) == "UNSUPPORTED"

    app.answers = True
    again = await app.connect_stream(VIDEO, H264)
    await app.news.until(lambda: app.statuses(again))
    assert app.peer_of(again).offers[-1]["peer_id"] != offer["peer_id"]


async def test_candidates_that_cannot_be_used_do_not_end_anything(app: Application) -> None:
    stream_id = await app.play(VIDEO, H264)
    about: Message = {"peer_id": app.peer_of(stream_id).offers[-1]["peer_id"], "generation": 1, "sdp_mid": "0"}
    for candidate, code in (
        ("candidate:garbage", "BAD_PARAMETER"),
        (HOST.replace("50000", "port"), "BAD_PARAMETER"),
        (HOST.replace("50000", "70000"), "BAD_PARAMETER"),
        (HOST.replace("typ host", "typ ghost"), "BAD_PARAMETER"),
        (HOST + " " + "x" * 1100, "BAD_PARAMETER"),
        (HOST.replace("192.0.2.1", "5ac3ecd5-4f6b-4f3d-9c2f-1d3e5b7a9c01.local"), "OK"),
        (HOST.replace("192.0.2.1", "224.0.0.1"), "OK"),
        (HOST.replace("192.0.2.1", "metadata.internal"), "OK"),
        (HOST.replace("udp", "tcp"), "OK"),
        ("", "OK"),
        (None, "OK"),
    ):
        assert (await app.ask("signaling.candidate", **about, candidate=candidate))["return_code"] == code, candidate
    await app.pictures(stream_id, 5)
    assert app.statuses(stream_id) == ["NOT_RUNNING", "RUNNING"]


async def test_messages_on_an_older_offer_are_refused_or_dropped(app: Application) -> None:
    first = await app.play(VIDEO, H264)
    peer = app.peer_of(first)
    old, (peer_id, generation) = peer.offers[0], (peer.offers[0]["peer_id"], peer.offers[0]["generation"])
    stale, _ = without_candidates(peer.connection.localDescription.sdp)
    second = await app.play(VIDEO, H264)
    assert peer.offers[-1]["generation"] > generation
    for named in (generation, generation + 100):
        about: Message = {"peer_id": peer_id, "generation": named}
        assert (await app.ask("signaling.answer", **about, sdp=stale))["return_code"] == "BAD_PARAMETER"
        assert "offer of generation" in app.told("openrois.reason")[-1]["reason"]
        assert (await app.ask("signaling.candidate", **about, candidate=HOST, sdp_mid="0"))["return_code"] == "OK"
    assert old["peer_id"] == app.peer_of(second).offers[-1]["peer_id"]
    await app.pictures(first, 3)
    await app.pictures(second, 3)
    assert not app.told("signaling.bye")


async def test_a_flood_of_candidates_is_dammed(app: Application) -> None:
    stream_id = await app.play(VIDEO, H264)
    about: Message = {"peer_id": app.peer_of(stream_id).offers[-1]["peer_id"], "generation": 1, "sdp_mid": "0"}
    codes: list[str] = []
    async with asyncio.TaskGroup() as tasks:

        async def trickle(port: int) -> None:
            candidate = HOST.replace("50000", str(port))
            codes.append((await app.ask("signaling.candidate", **about, candidate=candidate))["return_code"])

        for port in range(20_000, 21_000):
            tasks.create_task(trickle(port))
    assert set(codes) == {"OK", "OUT_OF_RESOURCES"}
    assert codes.count("OK") < 64, "a peer connection has at most 64 candidates"
    await app.pictures(stream_id, 5)
    assert await app.act("suspend", stream_id) == "OK"
    assert await app.act("resume", stream_id) == "OK"
    await app.pictures(stream_id, 5)


PROFILE: Message = {"identifier": {"code": "robot"}, "component_ids": ["robot/Arm"]}
ARM: Message = {"identifier": {"code": "urn:x-rois:def:component:OMG::Move"}, "name": "Arm"}


@pytest.mark.parametrize(
    "answer",
    [
        {"error": {"code": -32601, "message": "Method not found"}},
        {"result": None},
        {"result": {"return_code": "OK", "profile": None}},
        {"result": {"return_code": "ERROR"}},
        {"result": {"return_code": "OK", "profile": {"identifier": "robot"}}},
        {"result": {"return_code": "OK", "profile": {"identifier": {"code": "avatar"}}}},
        {"result": {"return_code": "OK", "profile": {"identifier": {"code": "gateway"}}}},
        {"result": {"return_code": "OK", "profile": {"identifier": {"code": "a/b"}}}},
        {"result": {"return_code": "OK", "profile": PROFILE}},
        {
            "result": {
                "return_code": "OK",
                "profile": PROFILE | {"component_ids": [VIDEO]},
                "component_profiles": {VIDEO: ARM},
            }
        },
        {"result": {"return_code": "OK", "profile": PROFILE, "component_profiles": {"robot/Arm": ARM | {"name": 5}}}},
        {
            "result": {
                "return_code": "OK",
                "profile": PROFILE | {"sub_profiles": [PROFILE]},
                "component_profiles": {"robot/Arm": ARM},
            }
        },
    ],
)
async def test_an_adapter_with_a_broken_profile_is_turned_away(demo: Demo, app: Application, answer: Message) -> None:
    async with connect(f"{demo.url}adapter", compression=None) as connection:
        closed = await served(connection, answer)
    assert closed.rcvd is not None
    assert closed.rcvd.code == 1008
    assert closed.rcvd.reason
    profile = (await app.ask("rois.system.get_profile"))["profile"]
    assert [each["identifier"]["code"] for each in profile["sub_profiles"]] == ["avatar"]
    assert not app.told("rois.system.profile_changed")


async def test_an_adapter_that_speaks_nonsense_is_ignored_until_it_speaks_sense(demo: Demo, app: Application) -> None:
    async with connect(f"{demo.url}adapter", compression=None) as connection:
        for nonsense in (
            "{",
            "[]",
            "5",
            request(),
            request(method="signaling.offer", id=None),
            '{"jsonrpc":"2.0","id":99,"result":{}}',
        ):
            await connection.send(nonsense)
        told = {"method": "signaling.offer", "params": {"peer_id": "avatar/1", "sdp": "v=0", "client_id": "x"}}
        await connection.send(json.dumps({"jsonrpc": "2.0"} | told))
        good = {"result": {"return_code": "OK", "profile": PROFILE, "component_profiles": {"robot/Arm": ARM}}}
        serving = asyncio.ensure_future(served(connection, good))
        await app.news.until(lambda: app.told("rois.system.profile_changed"))
        assert "robot/Arm" in (await app.ask("rois.system.get_profile"))["component_profiles"]
    await serving
    await app.news.until(lambda: len(app.told("rois.system.profile_changed")) == 2)
    with pytest.raises(Refused):
        await app.ask("rois.command.bind", component=5)


async def first_offer(app: Application) -> Message:
    await app.news.until(lambda: app.peers)
    [peer] = app.peers.values()
    return peer.offers[0]


async def served(connection: ClientConnection, answer: Message) -> ConnectionClosed:
    """Answer `get_profile` with `answer` and all else with -32601, until the connection ends; returns why it did."""
    try:
        async with asyncio.timeout(60):
            while True:
                asked = json.loads(await connection.recv())
                if "id" not in asked or "method" not in asked:
                    continue
                known = asked["method"] == "rois.system.get_profile"
                more = answer if known else {"error": {"code": -32601, "message": "Method not found"}}
                await connection.send(json.dumps({"jsonrpc": "2.0", "id": asked["id"]} | more))
    except ConnectionClosed as closed:
        return closed
