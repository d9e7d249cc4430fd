"""A whole session: after any messages the next valid request is answered correctly."""

import asyncio
import json
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.adapters import serve_adapter
from openrois.gateway.applications import serve_application
from openrois.transport.memory import MemoryStream, memory_pair
from tests.support.components import Bell, Lamp
from tests.support.deployment import until
from tests.support.plain import profile_result
from tests.support.schema import NOTIFICATIONS, RESULTS, check_notification, check_result
from tests.support.streams import Camera, FakeStreams
from tests.support.wire import hosted

REFS = ["robot/lamp", "robot/bell", "robot/camera", "robot/x", ""]
IDS = ["c1", "c2", "robot/1", "gateway/1", ""]

words = st.sampled_from(
    [*REFS, *IDS, "component_ref = 'robot/lamp'", "start", "switch", "rang", "brightness", "\ud800"]
)
loose = st.none() | st.booleans() | st.integers(-2, 2) | st.floats() | words
value = st.fixed_dictionaries({"name": words, "data_type_ref": words, "value": words | loose})
unit = st.fixed_dictionaries(
    {
        "component_ref": st.sampled_from(REFS),
        "command_type": st.sampled_from(["switch", "start", "stop", "fail", "connect_stream", "suspend_stream"]),
        "command_id": st.sampled_from(IDS),
    },
    optional={"arguments": st.lists(value, max_size=2), "delay_time": st.integers(-1, 2) | st.none()},
)
item = unit | st.fixed_dictionaries({"command_list": st.lists(unit, max_size=3)}) | loose
params = st.dictionaries(
    st.sampled_from(
        [
            "component_ref",
            "condition",
            "command_id",
            "query_type",
            "event_type",
            "subscribe_id",
            "event_id",
            "stream_id",
            "peer_id",
            "generation",
            "sdp",
            "candidate",
            "version",
            "parameters",
            "command_unit_list",
            "x",
        ]
    ),
    loose | st.lists(item, max_size=3) | st.lists(value, max_size=2),
    max_size=4,
)
execute = st.fixed_dictionaries({"command_unit_list": st.lists(item, min_size=1, max_size=4)})
methods = st.sampled_from([*RESULTS, "nothing"])
request = st.fixed_dictionaries(
    {"jsonrpc": st.just("2.0"), "id": st.integers(0, 5) | st.text(max_size=3), "method": methods, "params": params}
)
executing = st.fixed_dictionaries(
    {"jsonrpc": st.just("2.0"), "id": st.just(1), "method": st.just("rois.command.execute"), "params": execute}
)
message = (request | executing).map(json.dumps) | st.text(max_size=30)

CONNECT = json.dumps({"jsonrpc": "2.0", "id": "the end", "method": "rois.system.connect", "params": {}})
CODES = {-32700, -32600, -32601, -32602}


async def hear(stream: MemoryStream) -> dict[str, Any]:
    async with asyncio.timeout(60):
        heard: dict[str, Any] = json.loads(await stream.receive())
    return heard


async def converse(messages: list[str]) -> None:
    engine = Engine("gateway")
    await engine.attach(LocalRegistry("robot", [Lamp(), Bell(), Camera()], extension=FakeStreams()))
    near, far = memory_pair(capacity=1000)
    async with hosted(engine) as host:
        serving = asyncio.ensure_future(serve_application(host, near))
        asked = []
        for text in messages:
            await far.send(text)
            asked.append(text)
        await far.send(CONNECT)
        while (heard := await hear(far)).get("id") != "the end":
            if "method" in heard:
                assert heard["method"] in NOTIFICATIONS
                check_notification(heard["method"], heard["params"])
            elif "error" in heard:
                assert heard["error"]["code"] in CODES
            else:
                assert heard["result"]["return_code"]
        check_result("rois.system.connect", heard["result"])
        assert heard["result"] == {"return_code": "OK"}
        await far.close()
        async with asyncio.timeout(60):
            await serving


@settings(max_examples=25, deadline=None)
@given(st.lists(message, max_size=12))
def test_any_messages_of_an_application(messages: list[str]) -> None:
    asyncio.run(converse(messages))


told = st.fixed_dictionaries(
    {
        "jsonrpc": st.just("2.0"),
        "method": st.sampled_from([name for name in NOTIFICATIONS if name != "rois.system.profile_changed"]),
        "params": st.dictionaries(
            st.sampled_from(["command_id", "status", "event_id", "event_type", "subscribe_id", "client_id", "peer_id"]),
            loose,
            max_size=5,
        ),
    }
)
answered = st.fixed_dictionaries(
    # The gateway's own question is its third: whatever comes with that id answers it.
    {"jsonrpc": st.just("2.0"), "id": st.sampled_from([0, 1, 2, 4, 5])},
    optional={"result": params | loose, "error": loose | st.fixed_dictionaries({"code": loose, "message": loose})},
)


async def adapt(messages: list[str]) -> None:
    near, far = memory_pair(capacity=1000)
    engine = Engine("gateway")
    async with hosted(engine) as host:
        serving = asyncio.ensure_future(serve_adapter(host, near))
        request = await hear(far)
        await far.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], "result": profile_result("toy")}))
        request = await hear(far)
        error = {"code": -32601, "message": "Method not found"}
        await far.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], "error": error}))
        await until(engine, lambda ids: "plain" in ids)
        for text in messages:
            await far.send(text)
        asking = asyncio.ensure_future(engine.query("plain/toy", "mood"))
        while (heard := await hear(far)).get("method") != "rois.query.query":
            assert heard["error"]["code"] in CODES
        await far.send(
            json.dumps({"jsonrpc": "2.0", "id": heard["id"], "result": {"return_code": "OK", "results": []}})
        )
        assert await asking == ()
        await far.close()
        async with asyncio.timeout(60):
            await serving


@settings(max_examples=25, deadline=None)
@given(st.lists((told | answered).map(json.dumps) | st.text(max_size=30), max_size=12))
def test_any_messages_of_an_adapter(messages: list[str]) -> None:
    asyncio.run(adapt(messages))
