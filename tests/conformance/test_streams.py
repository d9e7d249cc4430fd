"""The extensions at the gateway: hello, the streaming methods, and whose stream it is."""

from typing import Any

import pytest

from openrois.interfaces.stream import MAX_STREAMS, REPORTS_AT_ONCE
from openrois.types.codes import StreamStatus
from openrois.types.streams import MAX_PLAYOUT
from tests.support import deployment
from tests.support.deployment import Application, Robot
from tests.support.viewer import CAMERA, STATUS, VERBS, execute, peer_of, statuses, stream_of


class TestHello:
    async def test_what_is_spoken(self, app: Application, other: Application) -> None:
        answer = await app.ask("openrois.hello", version="1", extensions=["rois.stream", "something.new"])
        assert answer["return_code"] == "OK"
        assert (answer["version"], answer["extensions"]) == ("1", ["rois.stream", "signaling", "openrois.lease"])
        theirs = await other.ask("openrois.hello", version="2")
        assert len({answer["client_id"], theirs["client_id"]}) == 2
        assert (await app.refused("openrois.hello"))["code"] == -32602

    async def test_extension_notifications_go_to_whoever_used_extensions(self, app: Application, robot: Robot) -> None:
        assert await execute(app, "c", "connect_stream") == "OK"
        (stream_id,) = robot.streams.streams
        robot.streams.announce(stream_id, StreamStatus.STREAMING_RUNNING)
        assert await app.settled() == []
        assert await app.code("openrois.hello", version="1") == "OK"
        robot.streams.announce(stream_id, StreamStatus.STREAMING_SUSPENDED)
        assert await app.next(STATUS) == {
            "stream_id": stream_id,
            "component_ref": CAMERA,
            "status": "STREAMING_SUSPENDED",
            "timestamp": "2026-06-01T12:00:00+00:00",
        }

    @pytest.mark.parametrize(
        ("method", "params"),
        [
            ("rois.stream.query_stream_status", {"stream_id": "x"}),
            ("signaling.restart", {"peer_id": "x"}),
            ("signaling.ice_servers", {}),
        ],
    )
    async def test_any_method_of_an_extension_is_enough(
        self, app: Application, robot: Robot, method: str, params: dict[str, Any]
    ) -> None:
        assert await execute(app, "c", "connect_stream") == "OK"
        await app.ask(method, **params)
        (stream_id,) = robot.streams.streams
        robot.streams.announce(stream_id, StreamStatus.STREAMING_RUNNING)
        assert await statuses(app, 1) == ["RUNNING"]


class TestStreamMethods:
    async def test_the_life_of_a_stream(self, app: Application, robot: Robot) -> None:
        stream_id = await stream_of(app)
        assert stream_id.startswith("robot/")
        assert app.told == []
        assert await statuses(app, 1) == ["NOT_RUNNING"]
        offer = await app.next("signaling.offer")
        assert offer["streams"][0]["stream_id"] == stream_id
        robot.streams.announce(stream_id, StreamStatus.STREAMING_RUNNING)
        assert await statuses(app, 1) == ["RUNNING"]
        for verb, told, status in [
            ("suspend_stream", ["SUSPENDED"], "SUSPENDED"),
            ("resume_stream", ["RESUMED", "RUNNING"], "RUNNING"),
        ]:
            assert await app.code(f"rois.stream.{verb}", stream_id=stream_id) == "OK"
            assert app.told == []
            assert await statuses(app, len(told)) == told
            answer = await app.ask("rois.stream.query_stream_status", stream_id=stream_id)
            assert answer == {"return_code": "OK", "status": f"STREAMING_{status}"}
        assert await app.code("rois.stream.disconnect_stream", stream_id=stream_id) == "OK"
        assert await statuses(app, 1) == ["NOT_CONNECTED"]
        for verb in VERBS:
            assert await app.code(f"rois.stream.{verb}", stream_id=stream_id) == "UNSUPPORTED"

    async def test_parameters_go_to_the_engine(self, app: Application, robot: Robot) -> None:
        parameters = [{"name": "encoding_parameters", "data_type_ref": "string", "value": '{"codecs":["video/VP8"]}'}]
        await app.ask("rois.stream.connect_stream", component_ref=CAMERA, parameters=parameters)
        method, params, client_id = robot.streams.calls[0]
        assert (method, params) == (
            "rois.stream.connect_stream",
            {"component_ref": CAMERA, "parameters": parameters},
        )
        assert client_id == (await app.ask("openrois.hello", version="1"))["client_id"]

    async def test_ice_servers_go_to_both_ends(self, robot: Robot) -> None:
        servers = [{"urls": ["stun:stun.example.org:3478"]}]
        async with (
            deployment.gateway(ice_servers=("stun:stun.example.org:3478",)) as gateway,
            deployment.adapter(gateway, robot.camera, extension=robot.streams),
            deployment.application(gateway) as app,
        ):
            await stream_of(app)
            assert robot.streams.calls[0][1]["ice_servers"] == servers
            answer = await app.ask("signaling.ice_servers")
            assert (answer["return_code"], answer["ice_servers"]) == ("OK", servers)
            assert answer["ttl"] > 0

    async def test_each_end_gets_credentials_of_its_own_and_the_engine_fresh_ones_with_a_restart(
        self, robot: Robot
    ) -> None:
        turn: dict[str, Any] = {
            "turn": ("turn:turn.example.org",),
            "turn_secret": "an example of a secret",
            "turn_ttl": 60,
        }
        async with (
            deployment.gateway(**turn) as gateway,
            deployment.adapter(gateway, *robot.parts(), extension=robot.streams),
            deployment.application(gateway) as app,
        ):
            await stream_of(app)
            peer_id = await peer_of(app)
            assert await app.code("signaling.restart", peer_id=peer_id) == "OK"
            answer = await app.ask("signaling.ice_servers")
        assert answer["ttl"] == 60
        (own,) = answer["ice_servers"]
        told = [params["ice_servers"] for _, params, _ in robot.streams.calls]
        for (server,) in told:
            assert server["urls"] == own["urls"] == ["turn:turn.example.org"]
            assert server["username"].endswith(":robot")
            assert server["credential"] != own["credential"]
        assert len(told) == 2

    async def test_what_is_refused(self, app: Application, subtests: pytest.Subtests) -> None:
        nothing = {"return_code": "UNSUPPORTED", "stream_id": ""}
        for ref in ("robot/nobody", "nowhere/camera", "camera", "gateway/camera"):
            with subtests.test(ref):
                assert await app.ask("rois.stream.connect_stream", component_ref=ref) == nothing
        misfits: list[tuple[str, dict[str, Any]]] = [
            ("rois.stream.connect_stream", {}),
            ("rois.stream.connect_stream", {"component_ref": CAMERA, "client_id": "x"}),
            ("rois.stream.connect_stream", {"component_ref": CAMERA, "ice_servers": []}),
            ("rois.stream.connect_stream", {"component_ref": CAMERA, "parameters": None}),
            ("rois.stream.suspend_stream", {"stream_id": 5}),
            ("rois.stream.suspend_stream", {"stream_id": "x", "component_ref": CAMERA}),
        ]
        for method, params in misfits:
            with subtests.test(f"{method} {params}"):
                assert (await app.refused(method, **params))["code"] == -32602

    async def test_the_engines_refusal_is_the_answer(
        self, app: Application, robot: Robot, monkeypatch: pytest.MonkeyPatch, subtests: pytest.Subtests
    ) -> None:
        for code in ("UNSUPPORTED", "OUT_OF_RESOURCES", "BAD_PARAMETER", "ERROR", "TIMEOUT"):
            with subtests.test(code):
                monkeypatch.setattr(robot.streams, "_connect", lambda *_asked, code=code: {"return_code": code})
                answer = await app.ask("rois.stream.connect_stream", component_ref=CAMERA)
                assert answer == {"return_code": code, "stream_id": ""}
        for wrong in ({}, {"return_code": "FINE"}, {"return_code": "OK", "extra": 1}, {"return_code": "OK"}):
            with subtests.test(str(wrong)):
                monkeypatch.setattr(robot.streams, "_connect", lambda *_asked, wrong=wrong: wrong)
                answer = await app.ask("rois.stream.connect_stream", component_ref=CAMERA)
                assert answer == {"return_code": "ERROR", "stream_id": ""}

    async def test_an_id_of_another_engine_is_not_taken(
        self, app: Application, robot: Robot, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        for minted in ("gateway/1", "nowhere/1", ""):
            wrong = {"return_code": "OK", "stream_id": minted}
            monkeypatch.setattr(robot.streams, "_connect", lambda *_asked, wrong=wrong: wrong)
            assert await app.code("rois.stream.connect_stream", component_ref=CAMERA) == "ERROR"
            assert await app.code("rois.stream.suspend_stream", stream_id=minted) == "UNSUPPORTED"

    async def test_playout_is_reported_by_the_owner_and_not_too_often(
        self, app: Application, other: Application, robot: Robot, subtests: pytest.Subtests
    ) -> None:
        method, stream_id = "rois.stream.report_playout", await stream_of(app)
        assert await app.ask(method, stream_id=stream_id, milliseconds=MAX_PLAYOUT) == {"return_code": "OK"}
        assert await other.code(method, stream_id=stream_id, milliseconds=1) == "UNSUPPORTED"
        assert await app.code(method, stream_id="robot/nothing", milliseconds=1) == "UNSUPPORTED"
        for wrong in (-1, MAX_PLAYOUT + 1, 10**30, 1.5, True, "1", None):
            with subtests.test(str(wrong)):
                error = await app.refused(method, stream_id=stream_id, milliseconds=wrong)
                assert error["code"] == -32602
        asked = [
            await app.begin(method, stream_id=stream_id, milliseconds=number) for number in range(4 * REPORTS_AT_ONCE)
        ]
        codes = [(await app.answer(request_id))["result"]["return_code"] for request_id in asked]
        assert codes[: REPORTS_AT_ONCE - 1] == ["OK"] * (REPORTS_AT_ONCE - 1)
        assert "OUT_OF_RESOURCES" in codes
        told = [params["milliseconds"] for name, params, _ in robot.streams.calls if name == method]
        assert told == [MAX_PLAYOUT, *(number for number, code in enumerate(codes) if code == "OK")]
        assert await other.code("rois.stream.query_stream_status", stream_id=await stream_of(other)) == "OK"

    async def test_only_so_many_even_at_once(self, app: Application, other: Application) -> None:
        asked = [await app.begin("rois.stream.connect_stream", component_ref=CAMERA) for _ in range(MAX_STREAMS + 4)]
        codes = [(await app.answer(request_id))["result"]["return_code"] for request_id in asked]
        assert sorted(codes) == ["OK"] * MAX_STREAMS + ["OUT_OF_RESOURCES"] * 4
        await stream_of(other)

    async def test_the_reply_comes_first_however_busy_the_connection(self, app: Application) -> None:
        """Each call causes notifications in the same breath; twelve run at once."""
        asked = [await app.begin("rois.stream.connect_stream", component_ref=CAMERA) for _ in range(12)]
        known: set[str] = set()
        for _ in range(36):
            message = await app.hear()
            if "result" in message:
                known.add(message["result"]["stream_id"])
            elif message["method"] == STATUS:
                assert message["params"]["stream_id"] in known
            else:
                assert message["params"]["streams"][0]["stream_id"] in known
        assert len(known) == len(asked)


class TestOwnership:
    async def test_a_foreign_stream_looks_like_none(self, app: Application, other: Application, robot: Robot) -> None:
        stream_id = await stream_of(app)
        await app.next("signaling.offer")
        calls = len(robot.streams.calls)
        for verb in VERBS:
            foreign = await other.ask(f"rois.stream.{verb}", stream_id=stream_id)
            unknown = await other.ask(f"rois.stream.{verb}", stream_id="robot/" + "0" * 32)
            assert foreign == unknown
            assert foreign["return_code"] == "UNSUPPORTED"
        for verb in ("disconnect_stream", "suspend_stream", "resume_stream"):
            assert await execute(other, verb, verb, stream_id) == "ERROR"
        condition = f"component_ref = '{CAMERA}' AND stream_id = '{stream_id}'"
        answer = await other.ask("rois.query.query", query_type="get_stream_status", condition=condition)
        assert answer == {"return_code": "UNSUPPORTED", "results": []}
        assert len(robot.streams.calls) == calls
        assert await other.settled() == []
        assert await app.code("rois.stream.suspend_stream", stream_id=stream_id) == "OK"

    async def test_a_foreign_peer_looks_like_none(self, app: Application, other: Application, robot: Robot) -> None:
        await stream_of(app)
        peer_id = await peer_of(app)
        calls = len(robot.streams.calls)
        for params in ({"peer_id": peer_id}, {"peer_id": "robot/" + "0" * 32}, {"peer_id": "x"}):
            assert await other.ask("signaling.restart", **params) == {"return_code": "UNSUPPORTED"}
            answer = {**params, "generation": 1, "sdp": "v=0"}
            assert await other.ask("signaling.answer", **answer) == {"return_code": "UNSUPPORTED"}
            candidate = {**params, "generation": 1, "candidate": "x", "sdp_mid": "0"}
            assert await other.ask("signaling.candidate", **candidate) == {"return_code": "UNSUPPORTED"}
        assert len(robot.streams.calls) == calls
        assert await app.code("signaling.restart", peer_id=peer_id) == "OK"

    async def test_status_goes_to_the_owner_alone(self, app: Application, other: Application, robot: Robot) -> None:
        mine, theirs = await stream_of(app), await stream_of(other)
        await app.ask("rois.event.subscribe", event_type="notify_stream_status")
        await other.ask("rois.event.subscribe", event_type="notify_stream_status")
        robot.streams.announce(theirs, StreamStatus.STREAMING_RUNNING)
        assert (await other.next("rois.event.notify_event"))["results"][2]["value"] == theirs
        robot.streams.announce(mine, StreamStatus.STREAMING_RUNNING)
        assert (await app.next("rois.event.notify_event"))["results"][2]["value"] == mine
