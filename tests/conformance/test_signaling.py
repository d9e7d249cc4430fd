"""Signaling at the gateway: owners of peers, limits and rates."""

import asyncio
import logging
from contextlib import AsyncExitStack
from typing import Any

import pytest
from openrois_signaling.messages import CANDIDATES_LIMIT, SDP_LIMIT
from openrois_signaling.relay import BURST, PEERS_PER_OWNER

from openrois.engine.tree import Tree
from openrois.errors import BadParameter, Unsupported
from openrois.gateway.server import Gateway
from openrois.types.codes import StreamStatus
from tests.support import deployment
from tests.support.deployment import Application, Robot
from tests.support.streams import Camera, FakeStreams
from tests.support.viewer import CAMERA, STATUS, peer_of, stream_of


class TestSignaling:
    async def test_messages_go_to_the_peers_engine_as_they_are(self, app: Application, robot: Robot) -> None:
        await stream_of(app)
        peer_id = await peer_of(app)
        robot.streams.calls.clear()
        answer = {"peer_id": peer_id, "generation": 1, "sdp": "v=0\r\n" + "x" * (SDP_LIMIT - 5)}
        candidate = {"peer_id": peer_id, "generation": 1, "candidate": "c", "sdp_mid": "0", "sdp_m_line_index": 0}
        last = {"peer_id": peer_id, "generation": 1, "candidate": None}
        for method, params in [("answer", answer), ("candidate", candidate), ("candidate", last)]:
            assert await app.ask(f"signaling.{method}", **params) == {"return_code": "OK"}
        asked = [(method.removeprefix("signaling."), params) for method, params, _ in robot.streams.calls]
        assert asked == [("answer", answer), ("candidate", candidate), ("candidate", last)]

    async def test_sizes_and_shapes(self, app: Application, robot: Robot, subtests: pytest.Subtests) -> None:
        await stream_of(app)
        peer_id = await peer_of(app)
        robot.streams.calls.clear()
        long = {"peer_id": peer_id, "generation": 1, "sdp": "x" * (SDP_LIMIT + 1)}
        assert await app.ask("signaling.answer", **long) == {"return_code": "BAD_PARAMETER"}
        assert await app.code("signaling.answer", **(long | {"peer_id": "robot/none"})) == "BAD_PARAMETER"
        [(method, bye, _)] = robot.streams.calls
        assert (method, bye["peer_id"]) == ("signaling.bye", peer_id)
        assert bye["reason"].startswith("the answer cannot be passed on: sdp: more than")
        robot.streams.calls.clear()
        misfits: list[tuple[str, dict[str, Any]]] = [
            ("answer", {"peer_id": peer_id, "generation": 1}),
            ("answer", {"peer_id": peer_id, "generation": "1", "sdp": "v=0"}),
            ("answer", {"peer_id": peer_id, "generation": 1, "sdp": "v=0", "client_id": "x"}),
            ("candidate", {"peer_id": peer_id, "generation": 1, "candidate": "c"}),
            ("restart", {}),
            ("ice_servers", {"x": 1}),
        ]
        for method, params in misfits:
            with subtests.test(f"{method} {params}"):
                error = await app.refused(f"signaling.{method}", **params)
                assert error["code"] == -32602
                assert all(set(problem) == {"path", "message"} for problem in error["data"])
        assert robot.streams.calls == []

    async def test_candidates_and_messages_are_bounded(
        self, app: Application, robot: Robot, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        # A machine that answers fewer messages a second than an application may send would never see the limit.
        monkeypatch.setattr("openrois_signaling.relay.RATE", 0.0)
        await stream_of(app)
        peer_id = await peer_of(app)
        candidate = {"peer_id": peer_id, "generation": 1, "candidate": "c", "sdp_mid": "0"}
        codes = [await app.code("signaling.candidate", **candidate) for _ in range(CANDIDATES_LIMIT + 2)]
        assert codes == ["OK"] * CANDIDATES_LIMIT + ["OUT_OF_RESOURCES"] * 2
        left = int(BURST) - len(codes)
        codes = [await app.code("signaling.restart", peer_id=peer_id) for _ in range(int(BURST))]
        assert codes == ["OK"] * left + ["OUT_OF_RESOURCES"] * (int(BURST) - left)
        assert len(robot.streams.calls) < CANDIDATES_LIMIT + int(BURST)

    async def test_the_engines_refusal_is_the_answer(
        self, app: Application, robot: Robot, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        await stream_of(app)
        peer_id = await peer_of(app)

        async def refuse(*_asked: object) -> None:
            raise BadParameter("garbage")

        monkeypatch.setattr(robot.streams, "call", refuse)
        assert await app.code("signaling.answer", peer_id=peer_id, generation=1, sdp="garbage") == "BAD_PARAMETER"

    async def test_a_peer_whose_engine_was_lost_just_now(
        self, app: Application, gateway: Gateway, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        await stream_of(app)
        peer_id = await peer_of(app)
        monkeypatch.setattr(gateway.engine, "tree", Tree("gateway"))
        assert await app.code("signaling.restart", peer_id=peer_id) == "UNSUPPORTED"

    async def test_capture_times_reach_the_application_as_they_are(
        self, app: Application, robot: Robot, caplog: pytest.LogCaptureFixture
    ) -> None:
        stream_id = await stream_of(app)
        clock = {"mid": "0", "ssrc": 2**32 - 1, "clock_rate": 90_000, "rtp_origin": 7, "wall": 1_800_000_000_000}
        told = {"peer_id": await peer_of(app), "senders": [clock]}
        client = robot.streams.streams[stream_id].client
        with caplog.at_level(logging.INFO):
            client.notify("signaling.capture_clocks", {**told, "senders": [{**clock, "ssrc": 2**32}]})
            client.notify("signaling.capture_clocks", {**told, "senders": [clock] * 17})
            client.notify("signaling.capture_clocks", told)
            assert await app.next("signaling.capture_clocks") == told
        assert "signaling.capture_clocks" not in await app.settled()
        assert "malformed messages of signaling" in caplog.text

    async def test_an_application_that_reconnects_for_ever_keeps_its_share(
        self, app: Application, robot: Robot
    ) -> None:
        for _ in range(PEERS_PER_OWNER + 2):
            await stream_of(app)
            await peer_of(app)
            assert await app.code("rois.system.disconnect") == "OK"
            app.told.clear()

    async def test_a_peer_too_many_is_ended_and_not_just_dropped(self, app: Application, robot: Robot) -> None:
        client = robot.streams.streams[await stream_of(app)].client
        for number in range(PEERS_PER_OWNER):
            robot.streams.offer(client, f"robot/{number}", [])
        while ("signaling.bye", "robot/63") not in {(method, p.get("peer_id")) for method, p, _ in robot.streams.calls}:
            robot.streams.called.clear()
            await robot.streams.called.wait()
        bye = next(params for method, params, _ in robot.streams.calls if method == "signaling.bye")
        assert bye["reason"] == f"the application has {PEERS_PER_OWNER} peer connections already"
        client.notify("signaling.bye", bye)
        assert await app.next("signaling.bye") == bye
        offers = [params["peer_id"] for method, params in app.told if method == "signaling.offer"]
        assert offers[-1] == "robot/62"

    async def test_an_engine_that_cannot_end_a_peer_harms_no_other(
        self, app: Application, robot: Robot, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
    ) -> None:
        await stream_of(app)
        peer_id = await peer_of(app)
        asked = asyncio.Event()

        async def refuse(*_asked: object) -> None:
            asked.set()
            raise Unsupported("there is no method signaling.bye")

        monkeypatch.setattr(robot.streams, "call", refuse)
        with caplog.at_level(logging.INFO):
            long = {"peer_id": peer_id, "generation": 1, "sdp": "x" * (SDP_LIMIT + 1)}
            assert await app.code("signaling.answer", **long) == "BAD_PARAMETER"
            await asked.wait()
            await app.settled()
        assert "does not end a peer connection that its application cannot have" in caplog.text

    async def test_an_engine_speaks_for_its_own_peers_and_streams(
        self, app: Application, robot: Robot, gateway: Gateway, stack: AsyncExitStack
    ) -> None:
        stream_id = await stream_of(app)
        peer_id = await peer_of(app)
        second = FakeStreams("second")
        await stack.enter_async_context(deployment.adapter(gateway, Camera(), engine_id="second", extension=second))
        other_stream = await stream_of(app, "second/camera")
        await app.next("signaling.offer")
        app.told.clear()
        client = second.streams[other_stream].client
        client.notify("signaling.bye", {"peer_id": peer_id, "reason": "mischief"})
        client.notify("signaling.capture_clocks", {"peer_id": peer_id, "senders": []})
        notice = {"component_ref": CAMERA, "status": "STREAMING_NOT_CONNECTED", "timestamp": "now"}
        client.notify(STATUS, {**notice, "stream_id": stream_id})
        client.notify(STATUS, {**notice, "stream_id": "second/1"})
        second.offer(client, "robot/peer", [])
        second.announce(other_stream, StreamStatus.STREAMING_RUNNING)
        assert (await app.next(STATUS))["stream_id"] == other_stream
        assert await app.settled() == []
        assert await app.code("signaling.restart", peer_id=peer_id) == "OK"
