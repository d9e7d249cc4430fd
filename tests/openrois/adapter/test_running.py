"""An adapter that runs: within a program that has a loop already, and as a program of its own."""

import asyncio
import os
import re
import signal
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from openrois.adapter import Component, Unsupported, serve
from openrois.client import Client
from openrois.contract import Client as Caller
from openrois.errors import Aborted
from openrois.gateway.server import Gateway
from openrois.testing import findings, launched
from openrois.types.streams import HolderNotification
from tests.support.basics import Navigation
from tests.support.components import Lamp
from tests.support.deployment import application, gateway, until

pytestmark = pytest.mark.extra(name="gateway")

EXAMPLE = Path(__file__).parents[3] / "docs" / "examples" / "lamp_adapter.py"


def address(running: Gateway) -> str:
    return running.url.replace("http", "ws", 1) + "adapter"


@asynccontextmanager
async def program(gateway_url: str, *source: str) -> AsyncIterator[asyncio.subprocess.Process]:
    """Run the example, or a program's text, with its log to be read."""
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *(source or (str(EXAMPLE),)),
        env={**os.environ, "OPENROIS_GATEWAY": gateway_url},
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            process.kill()
        await process.communicate()


async def said(process: asyncio.subprocess.Process, pattern: str) -> str:
    """Wait until the program has logged a line with `pattern`; return that line."""
    assert process.stderr is not None
    heard = ""
    async with asyncio.timeout(60):
        while not re.search(pattern, heard):
            line = await process.stderr.readline()
            assert line, f"the program ended: {heard}"
            heard = line.decode()
    return heard


async def ended(process: asyncio.subprocess.Process) -> int:
    async with asyncio.timeout(60):
        return await process.wait()


async def robot_at(running: Gateway) -> None:
    """Wait until a gateway has attached the adapter."""
    await until(running.engine, lambda ids: "robot" in ids)


class TestServe:
    async def test_components_are_behind_the_gateway_while_the_block_runs(self) -> None:
        lamp = Lamp()
        async with gateway() as running:
            async with serve(lamp, engine_id="robot", gateway=address(running)) as host:
                await until(running.engine, lambda ids: "robot" in ids)
                await running.engine.invoke("robot/lamp", "switch")
                assert lamp.total == 1
                assert host.engine.engine_id == "robot"
            await until(running.engine, lambda ids: "robot" not in ids)

    async def test_what_moves_is_tried_from_outside_with_a_holder(self) -> None:
        async with gateway() as running, serve(Navigation(), engine_id="robot", gateway=running.url):
            await until(running.engine, lambda ids: "robot" in ids)
            assert await findings(running.engine) == []
            with pytest.raises(Aborted, match="no application has control"):
                await running.engine.invoke("robot/navigation", "start")

    async def test_an_extension_answers_and_lives_around_the_components(self) -> None:
        class Door(Component, authority="Example", function="sensing"):
            async def connect(self) -> None:
                order.append("connected")

            async def disconnect(self) -> None:
                order.append("disconnected")

        class Streams:
            def engines(self) -> frozenset[str]:
                return frozenset({"robot"})

            async def call(self, method: str, params: Mapping[str, Any], client: Caller) -> dict[str, Any]:
                return {"return_code": "OK", "stream_id": f"robot/{params['component_ref']}"}

            async def set_holder(self, notification: HolderNotification, client: Caller) -> None:
                raise Unsupported("nothing here is held")

            async def forget_client(self, client: Caller) -> None:
                order.append("forgotten")

        @asynccontextmanager
        async def streams() -> AsyncIterator[Streams]:
            order.append("entered")
            yield Streams()
            order.append("left")

        order: list[str] = []
        async with gateway() as running:
            async with serve(Door(), engine_id="robot", gateway=running.url, extension=streams()):
                await until(running.engine, lambda ids: "robot" in ids)
                async with application(running) as app:
                    await app.ask("openrois.hello", version="1", extensions=["rois.stream", "signaling"])
                    answer = await app.ask("rois.stream.connect_stream", component_ref="robot/door", parameters=[])
                assert answer["stream_id"] == "robot/robot/door"
            assert [each for each in order if each != "forgotten"] == ["entered", "connected", "disconnected", "left"]

    async def test_the_environment_says_where_the_gateway_is(self, monkeypatch: pytest.MonkeyPatch) -> None:
        async with gateway() as running:
            monkeypatch.setenv("OPENROIS_GATEWAY", address(running))
            async with serve(Lamp(), engine_id="robot"):
                await until(running.engine, lambda ids: "robot" in ids)

    @pytest.mark.parametrize("is_environment", [True, False])
    async def test_of_several_gateways_the_next_is_served_when_one_has_gone(
        self, monkeypatch: pytest.MonkeyPatch, is_environment: bool
    ) -> None:
        async with AsyncExitStack() as one, AsyncExitStack() as two:
            stacks = {await stack.enter_async_context(gateway()): stack for stack in (one, two)}
            named = [each.url for each in stacks]
            if is_environment:
                monkeypatch.setenv("OPENROIS_GATEWAY", ",".join(named))
            async with serve(Lamp(), engine_id="robot", gateway=None if is_environment else named):
                attached = {asyncio.ensure_future(robot_at(each)): each for each in stacks}
                done, waiting = await asyncio.wait(attached, return_when=asyncio.FIRST_COMPLETED)
                (served,) = (attached[each] for each in done)
                await stacks[served].aclose()
                await asyncio.wait(waiting)

    async def test_what_the_gateway_prints_is_its_address(self) -> None:
        async with gateway() as running, serve(Lamp(), engine_id="robot", gateway=running.url):
            await until(running.engine, lambda ids: "robot" in ids)

    @pytest.mark.parametrize("wrong", ["ftp://127.0.0.1:8765/adapter", "127.0.0.1", "ws://"])
    async def test_an_address_that_is_none(self, wrong: str) -> None:
        with pytest.raises(ValueError, match="no address of a gateway"):
            async with serve(Lamp(), engine_id="robot", gateway=wrong):
                pass


class TestExample:
    """The README's adapter, as it stands there."""

    def test_it_is_short(self) -> None:
        assert len(EXAMPLE.read_text(encoding="utf-8").splitlines()) < 30

    async def test_an_application_uses_it(self) -> None:
        async with (
            launched(sys.executable, str(EXAMPLE)) as running,
            Client(running.url) as client,
            asyncio.timeout(60),
        ):
            (lamp_ref,) = await client.search("component_type = 'urn:x-rois:def:component:Example::Lamp'")
            assert lamp_ref == "lamp_1/lamp"
            lamp = client.component(lamp_ref)
            async with lamp.bound():
                await lamp.set_parameter(brightness=50)
                async with lamp.event("switched") as switched:
                    await lamp.command("switch", on=True)
                    assert await anext(aiter(switched)) == {"on": True}
                assert await lamp.query("power") == {"power": 3.0}
                assert await lamp.get_parameter() == {"brightness": 50}

    @pytest.mark.parametrize(
        ("options", "status", "words"),
        [
            (["--help"], 0, ("An adapter with lamp (Lamp)", "--gateway URL[,URL]", "OPENROIS_GATEWAY", "--engine-id")),
            (["--gateway", "lamp"], 2, ("--gateway: ", "no address of a gateway")),
            (["--gateway", "ws://a,lamp"], 2, ("--gateway: 'lamp'", "no address of a gateway")),
            (["--gatway", "x"], 2, ("--gatway is not known here; is it --gateway?",)),
        ],
    )
    async def test_its_command_line(self, options: list[str], status: int, words: tuple[str, ...]) -> None:
        async with asyncio.timeout(60):
            asked = await asyncio.create_subprocess_exec(
                sys.executable, str(EXAMPLE), *options,
                stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.STDOUT,
            )  # fmt: skip
            said_, _ = await asked.communicate()
        assert asked.returncode == status
        assert all(each in said_.decode() for each in words), said_.decode()

    async def test_it_keeps_the_contract(self) -> None:
        async with launched(sys.executable, str(EXAMPLE)) as running:
            assert await findings(running.engine) == []


class TestRun:
    @pytest.mark.parametrize("word", [signal.SIGINT, signal.SIGTERM])
    async def test_it_stops_when_it_is_told_to(self, word: signal.Signals) -> None:
        async with gateway() as running, program(address(running)) as process:
            await until(running.engine, lambda ids: "lamp_1" in ids)
            process.send_signal(word)
            await said(process, "lamp_1 has stopped")
            assert await ended(process) == 0
            await until(running.engine, lambda ids: "lamp_1" not in ids)

    async def test_an_address_in_the_environment_that_is_none_is_one_line(self) -> None:
        async with program("127.0.0.1:8765") as process:
            _, complaints = await process.communicate()
        problem = (
            b"OPENROIS_GATEWAY: '127.0.0.1:8765' is no address of a gateway, such as ws://127.0.0.1:8765/adapter\n"
        )
        assert (process.returncode, complaints) == (1, problem)

    async def test_a_second_signal_does_not_wait_for_what_does_not_end(self) -> None:
        source = (
            "import asyncio\n"
            "from openrois.adapter import Component, run\n"
            "class Arm(Component):\n"
            "    async def connect(self) -> None: ...\n"
            "    async def disconnect(self) -> None:\n"
            "        while True:\n"
            "            try:\n"
            "                print('clinging', flush=True)\n"
            "                await asyncio.Event().wait()\n"
            "            except asyncio.CancelledError:\n"
            "                pass\n"
            "run(Arm(), engine_id='robot', verbose=True)\n"
        )
        async with gateway() as running, program(address(running), "-c", source) as process:
            await until(running.engine, lambda ids: "robot" in ids)
            process.send_signal(signal.SIGTERM)
            assert process.stdout is not None
            async with asyncio.timeout(60):
                assert await process.stdout.readline() == b"clinging\n"
            process.send_signal(signal.SIGTERM)
            assert await ended(process) == -signal.SIGTERM

    async def test_it_waits_for_a_gateway_that_is_not_there_and_comes_back(self) -> None:
        async with gateway() as running:
            port = int(running.url.rpartition(":")[2].rstrip("/"))
        async with program(f"ws://127.0.0.1:{port}/adapter") as process:
            line = await said(process, "no gateway")
            assert f"no gateway answers at ws://127.0.0.1:{port}/adapter; `openrois gateway` starts one here" in line
            assert " I openrois.adapter.dialer: " in line
            await said(process, "trying again in")
            process.send_signal(signal.SIGINT)
            assert await ended(process) == 0

    async def test_a_gateway_that_refuses_it_says_why(self) -> None:
        async with gateway() as running, program(address(running)) as first:
            await until(running.engine, lambda ids: "lamp_1" in ids)
            async with program(address(running)) as second:
                assert "the engine id 'lamp_1' is taken already" in await said(second, "refuses this adapter")
            assert first.returncode is None

    async def test_a_component_that_cannot_be_reached_is_there_and_says_so(self) -> None:
        source = (
            "from openrois.adapter import Component, run\n"
            "class Arm(Component):\n"
            "    async def connect(self) -> None:\n"
            "        raise OSError('the arm is unplugged')\n"
            "run(Arm(), engine_id='robot')\n"
        )
        async with gateway() as running, program(address(running), "-c", source) as process:
            await said(process, "arm is not connected: .*the arm is unplugged")
            await until(running.engine, lambda ids: "robot" in ids)
            (status,) = await running.engine.query("robot/arm", "component_status")
            assert status.value == "ERROR"
