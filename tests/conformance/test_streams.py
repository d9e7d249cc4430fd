"""The extensions at the gateway: hello and the streaming methods."""

from typing import Any

import pytest

from openrois.interfaces.stream import MAX_STREAMS, REPORTS_AT_ONCE
from openrois.types.codes import Purpose, StreamStatus
from openrois.types.streams import MAX_PLAYOUT, MAX_PURPOSES
from tests.support import deployment
from tests.support.deployment import Application, Robot
from tests.support.viewer import CAMERA, STATUS, execute, peer_of, statuses, stream_of


class TestHello:
    async def test_what_is_spoken(self, app: Application, other: Application) -> None:
        answer = await app.ask("openrois.hello", version="1", extensions=["rois.stream", "something.new"])
        assert answer["return_code"] == "OK"
        spoken = ["rois.stream", "signaling", "openrois.directory", "openrois.lease"]
        assert (answer["version"], answer["extensions"]) == ("1", spoken)
        theirs = await other.ask("openrois.hello", version="2")
        assert len({answer["client_id"], theirs["client_id"]}) == 2
        assert (await app.refused("openrois.hello"))["code"] == -32602

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

    async def test_consent_is_stated_by_the_owner_of_a_stream(
        self, app: Application, other: Application, robot: Robot, subtests: pytest.Subtests
    ) -> None:
        method, stream_id = "rois.stream.set_consent", await stream_of(app)
        for consent in ([], ["live"], [str(each) for each in Purpose], ["live"] * MAX_PURPOSES):
            assert await app.ask(method, stream_id=stream_id, consent=consent) == {
                "return_code": "OK",
                "visitor_ref": "",
            }
            assert robot.streams.calls[-1][:2] == (method, {"stream_id": stream_id, "consent": consent})
        assert await other.code(method, stream_id=stream_id, consent=["live"]) == "UNSUPPORTED"
        assert await app.code(method, stream_id="robot/nothing", consent=["live"]) == "UNSUPPORTED"
        for wrong in (["all"], ["live"] * (MAX_PURPOSES + 1), "live", None, [1]):
            with subtests.test(str(wrong)):
                assert (await app.refused(method, stream_id=stream_id, consent=wrong))["code"] == -32602

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
