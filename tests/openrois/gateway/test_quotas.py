"""Quotas of one subject at a gateway that asks for tokens, and at one that does not."""

import asyncio
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import InvalidStatus

from openrois.engine.registry import LocalRegistry
from openrois.gateway.server import Gateway
from tests.support import deployment
from tests.support.guarded import ask, fresh, guarded
from tests.support.streams import Camera, FakeStreams

CAMERA = "robot/camera"


async def with_camera(gateway: Gateway) -> FakeStreams:
    """Attach a camera whose streams are none."""
    streams = FakeStreams()
    await gateway.engine.attach(LocalRegistry("robot", [Camera()], extension=streams))
    return streams


async def stream(connection: ClientConnection) -> Any:
    """Connect a stream; return its id, or the return code of the refusal."""
    result = (await ask(connection, "rois.stream.connect_stream", component_ref=CAMERA))["result"]
    return result["stream_id"] if result["return_code"] == "OK" else result["return_code"]


async def test_one_subject_has_so_many_connections(tmp_path: Path) -> None:
    async with guarded(tmp_path, subject_connections=2) as gateway:
        async with gateway.dial(fresh(sub="anna")), gateway.dial(fresh(sub="anna")):
            with pytest.raises(InvalidStatus) as refused:
                await gateway.dial(fresh(sub="anna"))
            assert refused.value.response.status_code == 429
            assert refused.value.response.body == b"one subject has at most 2 connections\n"
            async with gateway.dial(fresh(sub="bob")) as bob:
                assert (await ask(bob, "rois.system.connect"))["result"] == {"return_code": "OK"}
        async with deployment.patience():
            while True:
                try:
                    async with gateway.dial(fresh(sub="anna")):
                        break
                except InvalidStatus:
                    await asyncio.sleep(0)


async def test_one_subject_has_so_many_streams(tmp_path: Path) -> None:
    async with guarded(tmp_path, subject_streams=3) as gateway, AsyncExitStack() as stack:
        await with_camera(gateway.gateway)
        viewers = [await stack.enter_async_context(gateway.dial(fresh(sub="viewer", roles=["viewer"]))) for _ in "abc"]
        operator = await stack.enter_async_context(gateway.dial(fresh(sub="operator", roles=["operator"])))
        had = [await stream(viewers[0]), await stream(viewers[0]), await stream(viewers[1])]
        assert all(stream_id.startswith("robot/") for stream_id in had)
        assert {await stream(viewer) for viewer in viewers} == {"OUT_OF_RESOURCES"}
        assert (await stream(operator)).startswith("robot/")
        await ask(viewers[1], "rois.stream.disconnect_stream", stream_id=had[2])
        assert (await stream(viewers[2])).startswith("robot/")


async def test_without_tokens_each_connection_is_a_subject_of_its_own() -> None:
    async with (
        deployment.gateway(subject_connections=1, subject_sessions=1, subject_streams=2) as gateway,
        AsyncExitStack() as stack,
    ):
        await with_camera(gateway)
        viewers = [await stack.enter_async_context(deployment.application(gateway)) for _ in range(64)]
        for viewer in viewers:
            for _ in range(2):
                assert await viewer.code("rois.stream.connect_stream", component_ref=CAMERA) == "OK"
        assert await viewers[0].code("rois.stream.connect_stream", component_ref=CAMERA) == "OUT_OF_RESOURCES"


async def test_the_adapter_is_notified_of_clients_that_may_not_bind(tmp_path: Path) -> None:
    async with guarded(tmp_path) as gateway, AsyncExitStack() as stack:
        streams = await with_camera(gateway.gateway)
        for roles in (["viewer"], ["operator"], ["maintenance", "viewer"], ["administrator"]):
            connection = await stack.enter_async_context(gateway.dial(fresh(sub=roles[0], roles=roles)))
            assert (await stream(connection)).startswith("robot/")
    assert [params.get("may_bind") for _, params, _ in streams.calls] == [False, None, False, None]


async def test_an_application_cannot_say_itself_whether_it_may_bind(tmp_path: Path) -> None:
    async with guarded(tmp_path) as gateway, gateway.dial(fresh(sub="viewer", roles=["viewer"])) as viewer:
        await with_camera(gateway.gateway)
        answer = await ask(viewer, "rois.stream.connect_stream", component_ref=CAMERA, may_bind=True)
        assert answer["error"]["code"] == -32602
