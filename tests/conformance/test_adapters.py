"""The connection between gateway and adapter: requests to adapters, profiles of adapters, and wrong messages."""

import asyncio
import json
import logging
from contextlib import AsyncExitStack

import pytest
from websockets.asyncio.client import connect

from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.server import Gateway
from tests.support import deployment, wire
from tests.support.deployment import Adapter, Application
from tests.support.plain import (
    TOY,
    attached,
    component_profile,
    engine_profile,
    gateway_url,
    plain_adapter,
    profile_result,
    refusal,
)
from tests.support.session import settle


async def execute(app: Application, command_id: str, command: str, *arguments: dict[str, str]) -> str:
    unit = {"component_ref": TOY, "command_type": command, "command_id": command_id, "arguments": list(arguments)}
    return await app.code("rois.command.execute", command_unit_list=[unit])


class TestProfiles:
    async def test_what_is_not_acceptable_is_closed_with_the_reason(
        self, gateway: Gateway, adapter: Adapter, app: Application, subtests: pytest.Subtests
    ) -> None:
        missing = profile_result("toy")
        missing["component_profiles"] = {}
        deep = engine_profile("deep")
        for number in range(300):
            deep = engine_profile(f"deep-{number}", below=(deep,))
        for profile, words in [
            (profile_result("lamp", engine_id="robot"), "taken"),
            (profile_result("x", engine_id="gateway"), "taken"),
            (profile_result("x", engine_id="a/b"), "a/b"),
            (profile_result("x", engine_id=""), "engine id"),
            ({"return_code": "OK", "profile": engine_profile("plain", below=(engine_profile("plain"),))}, "taken"),
            ({**profile_result("toy"), "profile": engine_profile("plain", "robot/lamp")}, "robot/lamp"),
            (missing, "no profile"),
            ({"return_code": "OK", "profile": None}, "profile"),
            ({"return_code": "ERROR", "profile": None}, "profile"),
            ({"return_code": "OK", "profile": deep}, "profile"),
            ({**profile_result("toy"), "component_profiles": {"plain/toy": {"name": 1}}}, "malformed"),
            ({"return_code": "OK", "profile": engine_profile("日" * 200)}, "日日"),
            ("nonsense" * 2, ""),
        ]:
            with subtests.test(words):
                async with plain_adapter(gateway, profile if isinstance(profile, dict) else None) as wrong:
                    if not isinstance(profile, dict):
                        await wrong.socket.send(json.dumps({"jsonrpc": "2.0", "id": 1, "result": "nonsense"}))
                    code, reason = await refusal(wrong)
                assert code == 1008
                assert words in reason
                assert "\n" not in reason
        assert gateway.engine.directory.profile.engine_ids() == ("gateway", "robot")
        assert await app.settled() == []

    async def test_a_profile_that_becomes_unacceptable(self, gateway: Gateway, adapter: Adapter) -> None:
        async with plain_adapter(gateway) as changing:
            await attached(gateway)
            changing.profile = profile_result("lamp", engine_id="robot")
            await changing.tell("rois.system.profile_changed")
            code, reason = await refusal(changing)
            assert (code, "taken" in reason) == (1008, True)
        await deployment.until(gateway.engine, lambda ids: ids == ("gateway", "robot"))

    async def test_the_log_names_adapters_that_came_and_left(
        self, gateway: Gateway, adapter: Adapter, caplog: pytest.LogCaptureFixture
    ) -> None:
        caplog.set_level(logging.INFO, "openrois.gateway.adapters")
        async with plain_adapter(gateway):
            await attached(gateway)
        await deployment.until(gateway.engine, lambda ids: ids == ("gateway", "robot"))
        told = [record.getMessage() for record in caplog.records if record.name == "openrois.gateway.adapters"]
        assert told[-2:] == ["attached plain", "plain left: closed with 1000"]

    async def test_many_changes_at_once_are_two(self) -> None:
        may_go_on, looks = asyncio.Event(), 0

        async def sleep(_seconds: float) -> None:
            await may_go_on.wait()

        def look() -> None:
            nonlocal looks
            looks += 1

        async with wire.hosted(Engine("gateway")) as host, wire.engine_over(engine_id="fleet") as fleet:
            host.sleep = sleep
            async with wire.adapter_leg(host, fleet):
                host.engine.on_change(look)
                for number in range(20):
                    await fleet.attach(LocalRegistry(str(number), []))
                    await settle()
                assert looks == 1
                may_go_on.set()
                await deployment.until(host.engine, lambda ids: "19" in ids)
                assert looks == 2

    async def test_one_that_does_not_answer(self) -> None:
        async with (
            deployment.gateway(adapter_timeout=0.05) as gateway,
            plain_adapter(gateway, system__get_profile=None) as silent,
        ):
            code, reason = await refusal(silent)
            assert (code, "did not answer" in reason) == (1008, True)

    async def test_one_that_leaves_at_once(self, gateway: Gateway) -> None:
        async with connect(gateway_url(gateway)) as socket:
            await socket.recv()
        async with plain_adapter(gateway):
            await attached(gateway)

    async def test_components_it_does_not_list_are_not_its_own(
        self, gateway: Gateway, adapter: Adapter, app: Application
    ) -> None:
        profile = profile_result("toy")
        profile["component_profiles"]["robot/lamp"] = component_profile("lamp")
        async with plain_adapter(gateway, profile):
            await attached(gateway)
            result = await app.ask("rois.system.get_profile", condition="component_ref = 'robot/lamp'")
            assert result["component_profiles"]["robot/lamp"]["function"] == "actuation"

    async def test_the_path_alone_decides(self, gateway: Gateway, stack: AsyncExitStack) -> None:
        await stack.enter_async_context(plain_adapter(gateway, path="adapter?x=y"))
        await attached(gateway)
        for path in ("adapter/", "adapters", "x/adapter", "Adapter"):
            async with deployment.application(gateway, path) as app:
                assert await app.code("rois.system.connect") == "OK"


class TestPlainAdapter:
    """The base wire alone is enough for everything in it."""

    async def test_query(self, gateway: Gateway, stack: AsyncExitStack) -> None:
        plain = await stack.enter_async_context(plain_adapter(gateway, profile_result("toy", "it's")))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        answer = await app.ask("rois.query.query", query_type="mood", condition="component_ref = 'plain/it''s'")
        assert answer["results"] == [{"name": "text", "data_type_ref": "string", "value": "fine"}]
        assert plain.last("rois.query.query") == {"query_type": "mood", "condition": "component_ref = 'plain/it''s'"}

    async def test_one_that_answers_nothing_but_get_profile_is_attached(
        self, gateway: Gateway, stack: AsyncExitStack
    ) -> None:
        plain = await stack.enter_async_context(plain_adapter(gateway, openrois__hello=None))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        assert await app.code("rois.query.query", query_type="mood") == "OK"
        assert (await app.ask("openrois.hello", version="1"))["engines"] == []
        hello = {"version": "1", "extensions": ["rois.stream"], "engines": [], "client_id": ""}
        await plain.answer(plain.unanswered.get_nowait(), return_code="OK", **hello)
        await app.next("rois.system.profile_changed")
        assert (await app.ask("openrois.hello", version="1"))["engines"] == ["plain"]

    async def test_how_its_commands_may_end(
        self, gateway: Gateway, stack: AsyncExitStack, subtests: pytest.Subtests
    ) -> None:
        plain = await stack.enter_async_context(plain_adapter(gateway))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        plain.hold_completed = True
        for number, (answer, status) in enumerate(
            [
                ({"return_code": "OUT_OF_RESOURCES"}, "OUT_OF_RESOURCES"),
                ({"return_code": "TIMEOUT"}, "TIMEOUT"),
                ({"return_code": "BAD_PARAMETER"}, "ERROR"),
                ({"return_code": "UNSUPPORTED"}, "ERROR"),
                ({"return_code": "FINE"}, "ERROR"),
                ('{"jsonrpc":"2.0","id":"ID","error":{"code":-32602,"message":"no"}}', "ERROR"),
            ]
        ):
            with subtests.test(str(answer)):
                plain.answers["rois.command.execute"] = answer
                assert await execute(app, f"c{number}", "start") == "OK"
                assert await app.completed(f"c{number}") == {f"c{number}": status}
        del plain.answers["rois.command.execute"]
        for status in ("ERROR", "ABORT", "OUT_OF_RESOURCES", "TIMEOUT"):
            with subtests.test(status):
                plain.asked.clear()
                assert await execute(app, status, "start") == "OK"
                while not plain.asked:
                    await app.ask("rois.system.connect")
                theirs = plain.last("rois.command.execute")["command_unit_list"][0]["command_id"]
                await plain.tell_completed("unknown")
                await plain.tell_completed(theirs, "DONE")
                await plain.tell_completed(theirs, status)
                await plain.tell_completed(theirs, "OK")
                assert await app.completed(status) == {status: status}
        assert await app.settled() == []
