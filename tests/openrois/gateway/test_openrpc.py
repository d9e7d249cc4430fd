"""What a gateway says that it speaks is what it speaks."""

import json
from typing import Any

import aiohttp
import jsonschema
import pytest

from openrois.gateway import applications
from openrois.gateway.server import Gateway
from openrois.jsonrpc.session import RpcSession
from openrois.schema import openrpc
from openrois.transport.stream import StreamClosed
from tests.support.corpus import corpus
from tests.support.deployment import application, gateway
from tests.support.schema import NOTIFICATIONS, RESULTS


async def fetched(running: Gateway) -> dict[str, Any]:
    async with aiohttp.ClientSession() as client, client.get(f"{running.url}openrpc.json") as response:
        assert (response.status, response.content_type) == (200, "application/json")
        body = await response.read()
    assert body == openrpc()
    found: dict[str, Any] = json.loads(body)
    return found


async def test_every_method_that_it_lists_is_there() -> None:
    async with gateway() as running, application(running) as app:
        for method in (await fetched(running))["methods"]:
            # Params that no method takes: one that is there says so, one that is not says that.
            assert (await app.refused(method["name"], no_such_param=1))["code"] == -32602, method["name"]
        assert (await app.refused("rois.stream.open"))["code"] == -32601


async def test_every_method_that_is_there_is_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    served: set[str] = set()

    class Noted(RpcSession):
        async def run(self) -> StreamClosed:
            served.update(self.methods)
            return await super().run()

    monkeypatch.setattr(applications, "RpcSession", Noted)
    async with gateway() as running, application(running) as app:
        await app.ask("rois.system.connect")
        assert {method["name"] for method in (await fetched(running))["methods"]} == served


async def test_it_takes_the_params_that_it_says_and_refuses_all_others() -> None:
    async with gateway() as running, application(running) as app:
        for method in (await fetched(running))["methods"]:
            for case in corpus()[method["x-params"]["$ref"].rpartition("/")[2]]:
                if not isinstance(case.message, dict) or case.kind == "rule":
                    continue
                response = await app.answer(await app.begin(method["name"], **case.message))
                if method["name"].startswith("signaling.") and case.name.endswith("too long"):
                    assert response["result"] == {"return_code": "BAD_PARAMETER"}
                else:
                    assert ("result" in response) is case.is_valid, (method["name"], case.name)
                    assert case.is_valid or response["error"]["code"] == -32602


def test_it_is_what_a_strict_application_wrote_down() -> None:
    document = json.loads(openrpc())
    assert {method["name"] for method in document["methods"]} == set(RESULTS)
    assert {notification["name"] for notification in document["x-notifications"]} == set(NOTIFICATIONS)


async def test_an_application_may_connect_there_too() -> None:
    async with gateway() as running, application(running, "openrpc.json") as app:
        assert await app.code("rois.system.connect") == "OK"


async def test_an_answer_is_of_the_type_that_it_says() -> None:
    async with gateway() as running, application(running) as app:
        document = await fetched(running)
        for method, params in (
            ("rois.system.get_profile", {}),
            ("rois.command.search", {}),
            ("rois.command.bind", {"component_ref": "absent/x"}),
            ("openrois.hello", {"version": "1"}),
            ("signaling.ice_servers", {}),
        ):
            (listed,) = (found for found in document["methods"] if found["name"] == method)
            schema = {**listed["result"]["schema"], "components": document["components"]}
            jsonschema.Draft202012Validator(schema).validate(await app.ask(method, **params))
