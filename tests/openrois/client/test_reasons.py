"""Why: what a gateway and a component say of a refusal or failure stands in what the client raises."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from typing import Any

import pytest

from openrois.adapter import ComponentFailed as Failed
from openrois.adapter import components
from openrois.client import Client
from openrois.client.components import Navigation
from openrois.errors import Aborted, BadParameter, ComponentFailed, OutOfResources, RoISError, Unsupported
from openrois.testing import harness
from openrois.transport.memory import MemoryStream, memory_pair
from tests.support.grounds import Ground

pytestmark = pytest.mark.extra(name="base")

LAMP = "toys/lamp"
BIND = "rois.command.bind"


class Careful(components.Navigation):
    """Goes nowhere before it knows where."""

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        if "cellar" in changes.get("target_positions", ()):
            raise BadParameter("the cellar has no floor")
        return changes

    async def start(self) -> None:
        if not self.target_positions:
            raise Failed("set target_positions first")
        await asyncio.Event().wait()

    async def stop(self) -> None: ...


async def told(awaited: Any) -> RoISError:
    with pytest.raises(RoISError) as raised:
        await awaited
    return raised.value


class TestWhatIsRaised:
    async def test_a_refusal(self, ground: Ground, client: Client) -> None:
        async with ground.client() as other:
            await other.bind(LAMP)
            error = await told(client.bind(LAMP))
            assert isinstance(error, OutOfResources)
            why = "toys/lamp is bound by another application" if ground.extended else "another application has bound it"
            assert str(error) == f"rois.command.bind(toys/lamp): OUT_OF_RESOURCES ({why})"

    async def test_a_failed_command(self) -> None:
        async with harness(Careful()) as client:
            navigation = await client.find(Navigation)
            async with navigation.bound():
                error = await told(navigation.start())
                assert isinstance(error, ComponentFailed)
                assert str(error) == f"start of {navigation.component_ref} ended ERROR: set target_positions first"

    async def test_parameters_that_the_component_refuses(self) -> None:
        async with harness(Careful()) as client:
            navigation = await client.find(Navigation)
            async with navigation.bound():
                error = await told(navigation.set(target_positions=["cellar"]))
                assert str(error).endswith("ended ERROR: the cellar has no floor")

    async def test_what_follows_a_failure(self) -> None:
        async with harness(Careful()) as client:
            navigation = await client.find(Navigation)
            async with navigation.bound():
                execution = await client.execute(navigation.start(), navigation.stop())
                assert "set target_positions first" in str(await told(execution))
                after = await told(execution.commands[1])
                assert isinstance(after, Aborted)
                assert str(after).endswith("ended ABORT: an earlier command of the sequence ended ERROR")

    async def test_many_at_once_each_with_its_own(self, ground: Ground, client: Client) -> None:
        errors = await asyncio.gather(*(told(client.bind(f"toys/{number}")) for number in range(200)))
        for number, error in enumerate(errors):
            assert isinstance(error, Unsupported)
            why = f"there is no component 'toys/{number}'" if ground.extended else "there is no such component"
            assert str(error) == f"rois.command.bind(toys/{number}): UNSUPPORTED ({why})"


class TestStrangeReasons:
    async def refused(self, *reasons: dict[str, Any]) -> str:
        """Return what is raised where a gateway says these before it refuses a bind; ID stands for the request."""
        near, far = memory_pair()

        async def gateway() -> None:
            while True:
                request = json.loads(await far.receive())
                refusing = request["method"] == BIND
                for reason in reasons if refusing else ():
                    params = {name: request["id"] if value == "ID" else value for name, value in reason.items()}
                    await say(far, method="openrois.reason", params=params)
                code = "UNSUPPORTED" if refusing else "OK"
                await say(far, id=request["id"], result={"return_code": code})

        serving = asyncio.ensure_future(gateway())
        try:
            async with Client(dial=partial(opened, near), reconnect=None) as client:
                return str(await told(client.bind("a/b")))
        finally:
            serving.cancel()

    async def test_they_are_passed_over(self) -> None:
        plain = "rois.command.bind(a/b): UNSUPPORTED (there is no such component)"
        for reason in (
            {},
            {"reason": "x"},
            {"reason": 5, "request_id": "ID"},
            {"reason": "", "request_id": "ID"},
            {"reason": "x" * 501, "request_id": "ID"},
            {"reason": "x", "request_id": ["ID"]},
            {"reason": "x", "request_id": 0},
            {"reason": "x", "request_id": None},
            {"reason": "x", "command_id": "ID"},
            {"reason": "x", "command_id": "c"},
        ):
            assert await self.refused(reason) == plain

    async def test_the_last_one_counts_and_is_one_line(self) -> None:
        said = [{"reason": f"no\n{number}", "request_id": "ID", "new": 1} for number in range(50)]
        assert await self.refused(*said) == "rois.command.bind(a/b): UNSUPPORTED (no 49)"


@asynccontextmanager
async def opened(stream: MemoryStream) -> AsyncIterator[MemoryStream]:
    yield stream


async def say(stream: MemoryStream, **message: Any) -> None:
    await stream.send(json.dumps({"jsonrpc": "2.0", **message}))
