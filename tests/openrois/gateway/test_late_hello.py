"""An adapter whose answer to `openrois.hello` comes late hears all the same that it was taken in."""

import asyncio
import json
from typing import Any

import pytest

from openrois.engine.engine import Engine
from openrois.gateway.adapters import serve_adapter
from openrois.remote.attachment import ATTACHED
from openrois.transport.memory import MemoryStream, memory_pair
from tests.support.plain import profile_result
from tests.support.wire import hosted


async def _told(stream: MemoryStream, method: str) -> dict[str, Any]:
    """Return the next message of `method`; questions about the profile are answered meanwhile."""
    while True:
        message: dict[str, Any] = json.loads(await stream.receive())
        if message["method"] == method:
            return message
        if message["method"] == "rois.system.get_profile":
            await _answer(stream, message, **profile_result("toy"))


async def _answer(stream: MemoryStream, request: dict[str, Any], **result: Any) -> None:
    answer = {"jsonrpc": "2.0", "id": request["id"], "result": {"return_code": "OK", **result}}
    await stream.send(json.dumps(answer))


async def test_an_adapter_that_greets_late_is_told_that_it_is_attached(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("openrois.remote.remote_offer.HELLO_TIMEOUT", 0.01)
    near, far = memory_pair()
    engine, attached = Engine("gateway"), asyncio.Event()
    engine.on_change(attached.set)
    async with hosted(engine) as host, asyncio.TaskGroup() as tasks, asyncio.timeout(5):
        tasks.create_task(serve_adapter(host, near))
        hello = await _told(far, "openrois.hello")
        answering = tasks.create_task(_told(far, ATTACHED))
        await attached.wait()
        await _answer(far, hello, version="1", extensions=["rois.stream"], engines=[], client_id="")
        assert await answering == {"jsonrpc": "2.0", "method": ATTACHED, "params": {}}
        await far.close()
