"""The extensions at the gateway: hello, streaming in both forms, signaling, over one hop and over two."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from typing import Any

import pytest
from openrois_signaling.messages import CANDIDATES_LIMIT, SDP_LIMIT
from openrois_signaling.relay import BURST, PEERS_PER_OWNER

from openrois.engine import Engine
from openrois.errors import BadParameter
from openrois.gateway.server import Gateway
from openrois.interfaces.stream import MAX_STREAMS
from openrois.registry import LocalRegistry
from openrois.remote.serve import STREAM_GRACE
from openrois.types.codes import StreamStatus
from tests.support import deployment
from tests.support.deployment import Adapter, Application, Robot
from tests.support.streams import Camera, FakeStreams, SharedCamera
from tests.support.wire import adapter_leg, hosted
from tests.support.wire import application as memory_application

CAMERA = "robot/camera"
STATUS = "rois.stream.notify_stream_status"
VERBS = ("disconnect_stream", "suspend_stream", "resume_stream", "query_stream_status")


async def stream_of(app: Application, ref: str = CAMERA) -> str:
    answer = await app.ask("rois.stream.connect_stream", component_ref=ref)
    assert answer["return_code"] == "OK"
    return str(answer["stream_id"])


async def peer_of(app: Application) -> str:
    return str((await app.next("signaling.offer"))["peer_id"])


async def statuses(app: Application, count: int) -> list[str]:
    return [(await app.next(STATUS))["status"].removeprefix("STREAMING_") for _ in range(count)]


async def execute(app: Application, command_id: str, verb: str, stream_id: str | None = None) -> str:
    """Run a verb in strict RoIS and return how it ended."""
    value = {"name": "stream_id", "data_type_ref": "String", "value": stream_id or ""}
    arguments = [value] if stream_id is not None else []
    unit = {"component_ref": CAMERA, "command_type": verb, "command_id": command_id, "arguments": arguments}
    assert await app.code("rois.command.execute", command_unit_list=[unit]) == "OK"
    return (await app.completed(command_id))[command_id]


class TestHello:
    async def test_what_is_spoken(self, app: Application, other: Application) -> None:
        answer = await app.ask("openrois.hello", version="1", extensions=["rois.stream", "something.new"])
        assert answer["return_code"] == "OK"
        assert (answer["version"], answer["extensions"]) == ("1", ["rois.stream", "signaling"])
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
            "timestamp": "now",
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


class TestStrictForm:
    """An application that knows nothing of the extensions drives a stream's life."""

    async def test_the_life_of_a_stream(self, app: Application, robot: Robot) -> None:
        assert await execute(app, "connect", "connect_stream") == "OK"
        (result,) = (await app.ask("rois.command.get_command_result", command_id="connect"))["results"]
        assert (result["name"], result["data_type_ref"]) == ("stream_id", "string")
        stream_id = result["value"]
        assert list(robot.streams.streams) == [stream_id]
        condition = f"component_ref = '{CAMERA}' AND stream_id = '{stream_id}'"
        for verb, status in (("suspend_stream", "SUSPENDED"), ("resume_stream", "RUNNING")):
            assert await execute(app, verb, verb, stream_id) == "OK"
            answer = await app.ask("rois.query.query", query_type="get_stream_status", condition=condition)
            assert answer["results"] == [
                {"name": "status", "data_type_ref": "Stream_Status", "value": f"STREAMING_{status}"}
            ]
        assert await execute(app, "end", "disconnect_stream", stream_id) == "OK"
        assert robot.streams.streams == {}
        assert await app.code("rois.query.query", query_type="get_stream_status", condition=condition) == "UNSUPPORTED"
        assert await app.settled() == []

    async def test_events_after_completed(self, app: Application, robot: Robot) -> None:
        subscribed = await app.ask("rois.event.subscribe", event_type="notify_stream_status")
        unit = {"component_ref": CAMERA, "command_type": "connect_stream", "command_id": "c"}
        await app.ask("rois.command.execute", command_unit_list=[unit])
        assert (await app.hear())["method"] == "rois.command.completed"
        event = await app.next("rois.event.notify_event")
        assert event["subscribe_id"] == subscribed["subscribe_id"]
        assert event["event_type"] == "notify_stream_status"
        (stream_id,) = robot.streams.streams
        assert {result["name"]: result["value"] for result in event["results"]} == {
            "timestamp": "now",
            "status": "STREAMING_NOT_RUNNING",
            "stream_id": stream_id,
        }
        detail = await app.ask("rois.event.get_event_detail", event_id=event["event_id"])
        assert detail["results"] == event["results"]
        assert await app.code("rois.event.unsubscribe", subscribe_id=subscribed["subscribe_id"]) == "OK"
        robot.streams.announce(stream_id, StreamStatus.STREAMING_RUNNING)
        assert await app.settled() == []

    async def test_the_stored_parameters_are_used(self, app: Application, robot: Robot) -> None:
        value = {"name": "encoding_parameters", "data_type_ref": "String", "value": '{"codecs":["video/VP8"]}'}
        answer = await app.ask("rois.command.set_parameter", component_ref=CAMERA, parameters=[value])
        await app.completed(answer["command_id"])
        assert await execute(app, "c", "connect_stream") == "OK"
        assert robot.streams.calls[0][1]["parameters"] == [value]

    async def test_which_stream_has_to_be_said(self, app: Application, subtests: pytest.Subtests) -> None:
        stream_id = await stream_of(app)
        for condition, code in [
            ("", "BAD_PARAMETER"),
            (f"component_ref = '{CAMERA}'", "BAD_PARAMETER"),
            (f"stream_id LIKE '{stream_id}'", "BAD_PARAMETER"),
            (f"stream_id = '{stream_id}'", "OK"),
            (f"component_ref = 'robot/lamp' AND stream_id = '{stream_id}'", "UNSUPPORTED"),
            ("stream_id = 'x'", "UNSUPPORTED"),
        ]:
            with subtests.test(condition):
                params = {"query_type": "get_stream_status", "condition": condition}
                assert await app.code("rois.query.query", **params) == code
        assert await execute(app, "without", "suspend_stream") == "ERROR"
        assert await execute(app, "empty", "suspend_stream", "") == "ERROR"

    async def test_a_stream_is_of_its_component(self, gateway: Gateway, stack: AsyncExitStack) -> None:
        robot = Robot()
        cameras = (Camera("camera"), Camera("second"))
        await stack.enter_async_context(deployment.adapter(gateway, *cameras, extension=robot.streams))
        app = await stack.enter_async_context(deployment.application(gateway))
        stream_id = await stream_of(app, "robot/second")
        assert await execute(app, "wrong", "suspend_stream", stream_id) == "ERROR"
        for ref, code in ((CAMERA, "UNSUPPORTED"), ("robot/second", "OK")):
            condition = f"component_ref = '{ref}' AND stream_id = '{stream_id}'"
            assert await app.code("rois.query.query", query_type="get_stream_status", condition=condition) == code

    async def test_an_engine_without_extension_is_asked_in_strict_form(
        self, gateway: Gateway, stack: AsyncExitStack
    ) -> None:
        camera = SharedCamera()
        await stack.enter_async_context(deployment.adapter(gateway, camera))
        app = await stack.enter_async_context(deployment.application(gateway))
        assert await app.code("rois.event.subscribe", event_type="notify_stream_status") == "OK"
        assert await execute(app, "c", "connect_stream") == "OK"
        assert (await app.ask("rois.command.get_command_result", command_id="c"))["results"][0]["value"] == "the stream"
        assert (await app.next("rois.event.notify_event"))["results"][0]["value"] == "STREAMING_NOT_RUNNING"
        assert await execute(app, "d", "suspend_stream", "the stream") == "OK"
        assert camera.asked == ["connect_stream", "the stream"]
        assert await app.code("rois.query.query", query_type="get_stream_status") == "OK"
        assert await app.code("rois.stream.connect_stream", component_ref=CAMERA) == "UNSUPPORTED"


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

    async def test_candidates_and_messages_are_bounded(self, app: Application, robot: Robot) -> None:
        await stream_of(app)
        peer_id = await peer_of(app)
        candidate = {"peer_id": peer_id, "generation": 1, "candidate": "c", "sdp_mid": "0"}
        codes = [await app.code("signaling.candidate", **candidate) for _ in range(CANDIDATES_LIMIT + 2)]
        assert codes == ["OK"] * CANDIDATES_LIMIT + ["OUT_OF_RESOURCES"] * 2
        codes = [await app.code("signaling.restart", peer_id=peer_id) for _ in range(int(BURST))]
        assert codes[0] == "OK"
        assert codes[-1] == "OUT_OF_RESOURCES"
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
        monkeypatch.setattr(gateway.engine, "_routes", {})
        assert await app.code("signaling.restart", peer_id=peer_id) == "UNSUPPORTED"

    async def test_an_ended_peer_is_unknown(self, app: Application, robot: Robot) -> None:
        stream_id = await stream_of(app)
        peer_id = await peer_of(app)
        client = robot.streams.streams[stream_id].client
        client.notify("signaling.bye", {"peer_id": peer_id, "reason": "enough"})
        assert await app.next("signaling.bye") == {"peer_id": peer_id, "reason": "enough"}
        assert await app.code("signaling.restart", peer_id=peer_id) == "UNSUPPORTED"

    async def test_an_application_that_reconnects_for_ever_keeps_its_share(
        self, app: Application, robot: Robot
    ) -> None:
        for _ in range(PEERS_PER_OWNER + 2):
            await stream_of(app)
            await peer_of(app)
            assert await app.code("rois.system.disconnect") == "OK"
            app.told.clear()

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
        notice = {"component_ref": CAMERA, "status": "STREAMING_NOT_CONNECTED", "timestamp": "now"}
        client.notify(STATUS, {**notice, "stream_id": stream_id})
        client.notify(STATUS, {**notice, "stream_id": "second/1"})
        second.offer(client, "robot/peer", [])
        second.announce(other_stream, StreamStatus.STREAMING_RUNNING)
        assert (await app.next(STATUS))["stream_id"] == other_stream
        assert await app.settled() == []
        assert await app.code("signaling.restart", peer_id=peer_id) == "OK"


class TestEnds:
    async def test_a_session_that_ends_is_forgotten_by_the_engine(
        self, gateway: Gateway, adapter: Adapter, robot: Robot
    ) -> None:
        async with deployment.application(gateway) as leaving:
            await stream_of(leaving)
            client_id = (await leaving.ask("openrois.hello", version="1"))["client_id"]
        async with deployment.patience():
            await robot.streams.gone.wait()
        assert robot.streams.forgotten == [client_id]
        assert robot.streams.streams == {}

    async def test_disconnect_ends_the_streams(self, app: Application, robot: Robot) -> None:
        stream_id = await stream_of(app)
        assert await app.code("rois.system.disconnect") == "OK"
        async with deployment.patience():
            await robot.streams.gone.wait()
        assert await app.code("rois.stream.query_stream_status", stream_id=stream_id) == "UNSUPPORTED"
        await stream_of(app)

    @pytest.mark.parametrize("form", ["method", "command"])
    async def test_a_stream_that_is_made_for_somebody_who_left_is_ended(
        self, gateway: Gateway, adapter: Adapter, robot: Robot, form: str
    ) -> None:
        robot.streams.may_answer.clear()
        async with deployment.application(gateway) as leaving:
            if form == "method":
                await leaving.begin("rois.stream.connect_stream", component_ref=CAMERA)
            else:
                unit = {"component_ref": CAMERA, "command_type": "connect_stream", "command_id": "c"}
                await leaving.ask("rois.command.execute", command_unit_list=[unit, {**unit, "command_id": "d"}])
            async with deployment.patience():
                await robot.streams.called.wait()
        async with deployment.patience():
            await robot.streams.gone.wait()
        robot.streams.may_answer.set()
        async with deployment.application(gateway) as app, deployment.patience():
            while not robot.streams.forgotten[1:] or robot.streams.streams:
                await app.settled()
        assert len([call for call in robot.streams.calls if call[0] == "rois.stream.connect_stream"]) == 1

    async def test_a_stream_that_came_too_late_is_ended(self, robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
        sessions = deployment.adapter_sessions(monkeypatch)
        async with (
            deployment.gateway() as gateway,
            deployment.adapter(gateway, robot.camera, extension=robot.streams),
            deployment.application(gateway) as app,
        ):
            sessions[0].call_timeout = 0
            robot.streams.may_answer.clear()
            assert await app.code("rois.stream.connect_stream", component_ref=CAMERA) == "TIMEOUT"
            robot.streams.may_answer.set()
            async with deployment.patience():
                while len(robot.streams.calls) < 2 or robot.streams.streams:
                    await app.settled()

    async def test_a_lost_adapter(self, app: Application, other: Application, adapter: Adapter, robot: Robot) -> None:
        stream_id = await stream_of(app)
        peer_id = await peer_of(app)
        assert await statuses(app, 1) == ["NOT_RUNNING"]
        subscribed = await app.ask("rois.event.subscribe", event_type="notify_stream_status")
        await adapter.stop()
        notice = await app.next(STATUS)
        assert (notice["stream_id"], notice["component_ref"]) == (stream_id, CAMERA)
        assert notice["status"] == "STREAMING_NOT_CONNECTED"
        assert notice["timestamp"].endswith("+00:00")
        event = await app.next("rois.event.notify_event")
        assert event["subscribe_id"] == subscribed["subscribe_id"]
        assert event["results"][1]["value"] == "STREAMING_NOT_CONNECTED"
        assert await app.next("rois.system.profile_changed") == {}
        assert await app.code("rois.stream.query_stream_status", stream_id=stream_id) == "UNSUPPORTED"
        assert await app.code("signaling.restart", peer_id=peer_id) == "UNSUPPORTED"
        assert await app.settled() == []
        assert await other.settled() == ["rois.system.profile_changed"]
        await adapter.start()
        assert await stream_of(app) != stream_id
        assert await statuses(app, 1) == ["NOT_RUNNING"]
        assert await app.settled() == ["rois.system.profile_changed", "signaling.offer"]

    async def test_an_adapter_that_comes_and_goes_for_ever(self, gateway: Gateway, stack: AsyncExitStack) -> None:
        robot = Robot()
        attached = await stack.enter_async_context(deployment.adapter(gateway, robot.camera, extension=robot.streams))
        app = await stack.enter_async_context(deployment.application(gateway))
        for _ in range(PEERS_PER_OWNER + 2):
            await stream_of(app)
            await peer_of(app)
            await attached.stop()
            await attached.start()

    async def test_when_only_the_link_is_cut_streams_go_on_for_the_grace(
        self, gateway: Gateway, robot: Robot, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        slept: list[float] = []
        may_end = asyncio.Event()

        async def sleep(seconds: float) -> None:
            slept.append(seconds)
            await may_end.wait()

        async with deployment.adapter(gateway, robot.camera, extension=robot.streams) as adapter:
            adapter.host.sleep = sleep
            async with deployment.application(gateway) as app:
                await stream_of(app)
                await adapter.stop()
                await app.next("rois.system.profile_changed")
                assert slept == [STREAM_GRACE]
                assert len(robot.streams.streams) == 1
                may_end.set()
                async with deployment.patience():
                    while robot.streams.streams:
                        await app.settled()


class TestTwoHops:
    """A gateway behind the gateway: the application's client_id passes through, and so do ids and order."""

    @pytest.fixture
    async def middle(self) -> Engine:
        return Engine("fleet")

    @pytest.fixture
    async def leg(self, middle: Engine, robot: Robot) -> AsyncIterator[AsyncExitStack]:
        """Robot below fleet; leaving the inner stack takes the robot away."""
        async with AsyncExitStack() as outer:
            host = await outer.enter_async_context(hosted(middle))
            below = Engine("robot")
            await below.attach(LocalRegistry("robot", robot.parts(), extension=robot.streams))
            inner = await outer.enter_async_context(AsyncExitStack())
            await inner.enter_async_context(adapter_leg(host, below))
            yield inner

    async def test_one_client_id_and_the_right_order(self, middle: Engine, leg: AsyncExitStack, robot: Robot) -> None:
        async with hosted(Engine("gateway")) as host, adapter_leg(host, middle), memory_application(host) as app:
            hello = await app.ask("openrois.hello", version="1", extensions=[])
            for _ in range(3):
                answer = await app.ask("rois.stream.connect_stream", component_ref=CAMERA)
                assert answer["stream_id"].startswith("robot/")
                assert app.told.empty() or app.told.qsize() <= 2
                assert (await app.next(STATUS))["stream_id"] == answer["stream_id"]
                offer = await app.next("signaling.offer")
                assert await app.ask("signaling.restart", peer_id=offer["peer_id"]) == {"return_code": "OK"}
            assert {client_id for _, _, client_id in robot.streams.calls} == {hello["client_id"]}

    async def test_the_application_leaves(self, middle: Engine, leg: AsyncExitStack, robot: Robot) -> None:
        async with hosted(Engine("gateway")) as host, adapter_leg(host, middle):
            async with memory_application(host) as app:
                await app.ask("rois.stream.connect_stream", component_ref=CAMERA)
            async with deployment.patience():
                await robot.streams.gone.wait()
            assert robot.streams.streams == {}

    async def test_the_adapter_is_lost(self, middle: Engine, leg: AsyncExitStack, robot: Robot) -> None:
        async with hosted(Engine("gateway")) as host, adapter_leg(host, middle), memory_application(host) as app:
            answer = await app.ask("rois.stream.connect_stream", component_ref=CAMERA)
            await app.next(STATUS)
            await leg.aclose()
            notice = await app.next(STATUS)
            assert (notice["stream_id"], notice["status"]) == (answer["stream_id"], "STREAMING_NOT_CONNECTED")
            await deployment.until(host.engine, lambda ids: "robot" not in ids)
            query = await app.ask("rois.stream.query_stream_status", stream_id=answer["stream_id"])
            assert query["return_code"] == "UNSUPPORTED"
