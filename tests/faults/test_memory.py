"""F26: a gateway with little memory, whose applications do not read."""

import asyncio
import random
import socket
from contextlib import AsyncExitStack
from pathlib import Path

import pytest
from aiohttp import ClientSession

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.session.session import EngineHost
from tests.support.components import Bell, Lamp
from tests.support.ground import gateway_program
from tests.support.invariants import Book
from tests.support.memory import limited
from tests.support.seeds import SOME

pytestmark = [pytest.mark.long, pytest.mark.timeout(600)]

MEGABYTES = 300
APPLICATIONS = 60
TUNE = "x" * 16_000


@pytest.mark.parametrize("seed", SOME)
async def test_f26_events_go_before_the_gateway_does(seed: int, tmp_path: Path) -> None:
    bell, lamp, book = Bell(), Lamp(), Book()
    with limited(MEGABYTES) as memory:
        running = gateway_program("--port", "0", log=tmp_path / "gateway.log", prefix=memory.prefix)
        async with running as gateway, AsyncExitStack() as stack:
            url = gateway.first.split()[-1]
            tasks = await stack.enter_async_context(TaskScope())
            engine = Engine("robot")
            await engine.attach(LocalRegistry("robot", (bell, lamp)))
            dialling = await stack.enter_async_context(TaskScope())
            dialling.start(serve_parent(EngineHost(engine, tasks), f"{url.replace('http', 'ws', 1)}adapter"))
            honest = await stack.enter_async_context(book.witness(url, extended=True))
            await honest.attached()
            assert await honest.bind() == "OK"
            for _ in range(APPLICATIONS):
                slow = await stack.enter_async_context(book.witness(url, extended=True))
                await slow.subscribe("rang", "robot/bell")
                slow.socket.transport.pause_reading()
                slow.socket.transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            for number in range(random.Random(seed).randrange(400, 800)):
                bell.ring(f"{number}{TUNE}")
                if number % 10 == 0:
                    assert await honest.code("rois.system.get_profile", condition="") == "OK"
                await asyncio.sleep(0)
            lamp.may_end.set()
            assert await honest.execute("c") == "OK"
            assert await honest.end_of("c") == "OK"
            async with ClientSession() as http, http.get(f"{url}readyz") as answer:
                assert answer.status == 200, await answer.text()
            assert gateway.process.returncode is None
            assert memory.peak < MEGABYTES << 20
            # Those that did not read are not asked what they have heard.
            book.witnesses[1:] = []
    book.check()
