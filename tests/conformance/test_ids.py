"""Ids on both legs: those that engines assign, and those that applications choose."""

from contextlib import AsyncExitStack
from typing import Any

import pytest

from openrois.gateway.server import Gateway
from tests.support import deployment
from tests.support.components import Bell, Lamp
from tests.support.deployment import Adapter, Application
from tests.support.plain import TOY, PlainAdapter, attached, plain_adapter

EXECUTE = "rois.command.execute"


def unit(command_id: str, command: str = "say") -> dict[str, Any]:
    return {"component_ref": TOY, "command_type": command, "command_id": command_id}


async def run(app: Application, command_id: str, command: str = "say") -> str:
    """Run a command; return how it completed."""
    assert await app.code(EXECUTE, command_unit_list=[unit(command_id, command)]) == "OK"
    return (await app.completed(command_id))[command_id]


def ids_at(plain: PlainAdapter) -> list[str]:
    """Return the ids of the commands that the adapter was sent."""
    return [params["command_unit_list"][0]["command_id"] for method, params in plain.asked if method == EXECUTE]


@pytest.fixture
async def plain(gateway: Gateway, stack: AsyncExitStack) -> PlainAdapter:
    adapter = await stack.enter_async_context(plain_adapter(gateway))
    await attached(gateway)
    return adapter


@pytest.fixture
async def ann(gateway: Gateway, plain: PlainAdapter, stack: AsyncExitStack) -> Application:
    return await stack.enter_async_context(deployment.application(gateway))


@pytest.fixture
async def ben(gateway: Gateway, plain: PlainAdapter, stack: AsyncExitStack) -> Application:
    return await stack.enter_async_context(deployment.application(gateway))


class TestThoseThatEnginesAssign:
    async def test_begin_with_the_engine_that_owns_the_component(
        self, gateway: Gateway, adapter: Adapter, stack: AsyncExitStack
    ) -> None:
        await stack.enter_async_context(deployment.two_level(adapter, Lamp(), Bell(), engine_id="below"))
        app = await stack.enter_async_context(deployment.application(gateway))
        await deployment.until(gateway.engine, lambda ids: "below" in ids)
        for engine_id in ("robot", "below"):
            lamp = f"{engine_id}/lamp"
            await app.ask("rois.command.bind", component_ref=lamp)
            assigned = []
            for _ in range(2):
                answer = await app.ask("rois.command.set_parameter", component_ref=lamp, parameters=[])
                assert await app.completed(answer["command_id"]) == {answer["command_id"]: "OK"}
                assert await app.code("rois.command.get_command_result", command_id=answer["command_id"]) == "OK"
                condition = f"component_ref = '{engine_id}/bell'"
                told = await app.ask("rois.event.subscribe", event_type="rang", condition=condition)
                assigned += [answer["command_id"], told["subscribe_id"]]
            assert {each.partition("/")[0] for each in assigned} == {engine_id}
            assert len({each.partition("/")[2] for each in assigned}) == 4
            assert all(len(each.partition("/")[2]) == 32 for each in assigned)

    async def test_are_looked_up_here_and_never_at_the_adapter(self, plain: PlainAdapter, ann: Application) -> None:
        subscribed = (await ann.ask("rois.event.subscribe", event_type="laughed"))["subscribe_id"]
        assert subscribed.startswith("plain/")
        assert subscribed != f"plain/sub-{plain.minted}"
        # The adapter's own id is unknown here: it ends nothing, and gives nothing.
        assert await ann.code("rois.event.unsubscribe", subscribe_id=f"plain/sub-{plain.minted}") == "OK"
        assert "rois.event.unsubscribe" not in [method for method, _ in plain.asked]
        adapters_id = f"plain/sub-{plain.minted}"
        set_id = (await ann.ask("rois.command.set_parameter", component_ref=TOY, parameters=[]))["command_id"]
        await ann.completed(set_id)
        assert set_id.startswith("plain/")
        asked = len(plain.asked)
        assert await ann.code("rois.command.get_command_result", command_id=set_id) == "OK"
        other_id = f"plain/param-{plain.minted}"
        assert await ann.code("rois.command.get_command_result", command_id=other_id) == "BAD_PARAMETER"
        assert len(plain.asked) == asked
        await ann.ask("rois.event.unsubscribe", subscribe_id=subscribed)
        assert plain.last("rois.event.unsubscribe") == {"subscribe_id": adapters_id}


class TestThoseThatApplicationsChoose:
    async def test_reach_the_adapter_while_they_are_free_there(
        self, plain: PlainAdapter, ann: Application, ben: Application
    ) -> None:
        for command_id in ("c1", "日本", "x/1", "a" * 1024):
            assert await run(ann, command_id) == "OK"
            assert ids_at(plain)[-1] == command_id
        await run(ben, "c1")
        await run(ben, "a" * 1024)
        again, long = ids_at(plain)[-2:]
        assert again.startswith("c1-")
        assert len(again) == len("c1-") + 32
        assert len(long) == 32

    async def test_two_that_run_at_a_time_are_told_apart(
        self, plain: PlainAdapter, ann: Application, ben: Application
    ) -> None:
        plain.hold_completed = True
        for app in (ann, ben):
            assert await app.code(EXECUTE, command_unit_list=[unit("c")]) == "OK"
            await plain.heard(EXECUTE)
        first, second = ids_at(plain)
        assert first == "c"
        await plain.tell_completed(second, "ABORT")
        assert await ben.completed("c") == {"c": "ABORT"}
        assert await ann.settled() == []
        await plain.tell_completed(first)
        assert await ann.completed("c") == {"c": "OK"}

    async def test_one_that_the_adapter_remembers_is_sent_again_under_another(
        self, plain: PlainAdapter, ann: Application
    ) -> None:
        """As after a restart of the gateway: the adapter knows ids from before."""
        plain.known.add("c1")
        assert await run(ann, "c1") == "OK"
        assert ids_at(plain)[0] == "c1"
        assert ids_at(plain)[1].startswith("c1-")

    async def test_a_stop_has_the_id_of_the_application(self, plain: PlainAdapter, ann: Application) -> None:
        plain.profile["component_profiles"][TOY]["command_profiles"].append({"name": "stop"})
        await plain.tell("rois.system.profile_changed")
        await ann.next("rois.system.profile_changed")
        await run(ann, "halt", "stop")
        assert ids_at(plain) == ["halt"]
