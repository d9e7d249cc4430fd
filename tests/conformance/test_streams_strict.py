"""Streaming in strict RoIS terms: execute, query and subscribe alone."""

from contextlib import AsyncExitStack

import pytest

from openrois.gateway.server import Gateway
from openrois.types.codes import StreamStatus
from tests.support import deployment
from tests.support.deployment import Adapter, Application, Robot
from tests.support.streams import Camera, SharedCamera
from tests.support.viewer import CAMERA, execute, stream_of


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
            "timestamp": "2026-06-01T12:00:00+00:00",
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
        assert (await app.next("rois.event.notify_event"))["results"][1]["value"] == "STREAMING_NOT_RUNNING"
        assert await execute(app, "d", "suspend_stream", "the stream") == "OK"
        assert camera.asked == ["connect_stream", "the stream"]
        assert await app.code("rois.query.query", query_type="get_stream_status") == "OK"
        named = {"query_type": "get_stream_status", "condition": "stream_id = 'x'"}
        assert await app.code("rois.query.query", **named) == "BAD_PARAMETER"
        assert await app.code("rois.stream.connect_stream", component_ref=CAMERA) == "UNSUPPORTED"


class TestParameters:
    """What applications set for their streams is their own."""

    def value(self, name: str, value: str) -> dict[str, str]:
        return {"name": name, "data_type_ref": "any", "value": value}

    async def set_parameters(self, app: Application, **values: str) -> dict[str, str]:
        """Set parameters and return how that ended, by command_id."""
        parameters = [self.value(name, value) for name, value in values.items()]
        answer = await app.ask("rois.command.set_parameter", component_ref=CAMERA, parameters=parameters)
        return await app.completed(answer["command_id"])

    async def parameters(self, app: Application) -> dict[str, str]:
        answer = await app.ask("rois.command.get_parameter", component_ref=CAMERA)
        assert {p["data_type_ref"] for p in answer["parameters"]} <= {"String"}
        return {p["name"]: p["value"] for p in answer["parameters"]}

    async def test_applications_do_not_overwrite_each_others(
        self, app: Application, other: Application, robot: Robot
    ) -> None:
        await self.set_parameters(app, encoding_parameters='{"codecs":["video/VP8"]}')
        await self.set_parameters(other, encoding_parameters='{"codecs":["video/H264"]}', transport_parameters="{}")
        assert await self.parameters(app) == {"encoding_parameters": '{"codecs":["video/VP8"]}'}
        assert await self.parameters(other) == {
            "encoding_parameters": '{"codecs":["video/H264"]}',
            "transport_parameters": "{}",
        }
        for session in (app, other):
            assert await execute(session, "c", "connect_stream") == "OK"
        used = [
            {p["name"]: p["value"] for p in params["parameters"]}
            for method, params, _ in robot.streams.calls
            if method == "rois.stream.connect_stream"
        ]
        assert used == [await self.parameters(app), await self.parameters(other)]

    async def test_also_by_execute(self, app: Application, other: Application) -> None:
        unit = {"component_ref": CAMERA, "command_type": "set_parameter", "command_id": "c"}
        arguments = [self.value("encoding_parameters", "{}")]
        await app.ask("rois.command.execute", command_unit_list=[{**unit, "arguments": arguments}])
        assert await app.completed("c") == {"c": "OK"}
        assert await self.parameters(app) == {"encoding_parameters": "{}"}
        assert await self.parameters(other) == {}

    async def test_until_disconnect_or_the_adapter_is_lost(self, app: Application, adapter: Adapter) -> None:
        await self.set_parameters(app, encoding_parameters="{}")
        assert await self.parameters(app) == {"encoding_parameters": "{}"}
        await app.code("rois.system.disconnect")
        assert await self.parameters(app) == {}
        await self.set_parameters(app, encoding_parameters="{}")
        await adapter.stop()
        await adapter.start()
        assert await self.parameters(app) == {}

    async def test_an_empty_one_is_none(self, app: Application, robot: Robot) -> None:
        await self.set_parameters(app, encoding_parameters="{}")
        await self.set_parameters(app, encoding_parameters="")
        assert await self.parameters(app) == {}
        assert await execute(app, "c", "connect_stream") == "OK"
        assert robot.streams.calls[0][1]["parameters"] == []

    async def test_other_parameters_are_the_components(self, app: Application, robot: Robot) -> None:
        """A refusal of theirs changes nothing."""
        (status,) = (await self.set_parameters(app, encoding_parameters="{}", available_encodings="x")).values()
        assert status == "ERROR"
        assert await self.parameters(app) == {}
        answer = await app.ask("rois.command.set_parameter", component_ref=CAMERA, parameters=[])
        assert await app.completed(answer["command_id"]) == {answer["command_id"]: "OK"}

    async def test_of_an_engine_without_extension_they_are_shared(
        self, gateway: Gateway, stack: AsyncExitStack
    ) -> None:
        await stack.enter_async_context(deployment.adapter(gateway, SharedCamera()))
        one = await stack.enter_async_context(deployment.application(gateway))
        other = await stack.enter_async_context(deployment.application(gateway))
        await self.set_parameters(one, encoding_parameters="{}")
        assert await self.parameters(other) == {"encoding_parameters": "{}"}
