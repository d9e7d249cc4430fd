"""Thousands of wrong messages on live connections: each gets its one right error, and others get their answers."""

import asyncio
import json
from itertools import islice

import pytest
from openrois_bench.errors import BenchFailed
from openrois_bench.gateway.deployment import deployed
from openrois_bench.gateway.load import Application, Door, applications
from openrois_bench.gateway.malformed.bystander import Bystander
from openrois_bench.gateway.malformed.flood import Found, flood
from openrois_bench.gateway.malformed.messages import malformed
from openrois_bench.gateway.security import OPEN

COUNT = 5000


async def test_each_gets_its_one_right_error_while_another_client_works() -> None:
    over = asyncio.Event()
    async with deployed(OPEN) as deployment, applications(deployment.door, 1) as (application,):
        bystander = Bystander(application, 200)
        working = asyncio.ensure_future(bystander.run(over))
        found = await flood(deployment.door, COUNT, 0, seed=1)
        over.set()
        await working
    assert found.right, (found.wrong, found.missing)
    assert found.sent == COUNT
    assert set(found.by_code) == {-32700, -32600, -32601, -32602}
    assert min(found.by_code.values()) > COUNT / 10
    assert bystander.waits


def test_the_same_seed_says_the_same_and_no_id_comes_twice() -> None:
    messages = list(islice(malformed(7), 2000))
    assert messages == list(islice(malformed(7), 2000))
    assert messages != list(islice(malformed(8), 2000))
    ids = [message.answered_as for message in messages if message.answered_as is not None]
    assert len(ids) == len(set(ids))


class Told(Application):
    """A connection on which a test says what comes."""

    def __init__(self) -> None:
        super().__init__()
        self.asked = asyncio.Event()

    def send(self, payload: bytes) -> None:
        self.asked.set()


@pytest.mark.parametrize("answer", [{"id": 1, "result": {"return_code": "OK"}}, {"id": 0, "error": {"code": -32000}}])
async def test_a_bystander_takes_no_other_answer(answer: dict[str, object]) -> None:
    told, over = Told(), asyncio.Event()
    working = asyncio.ensure_future(Bystander(told, 1000).run(over))
    await told.asked.wait()
    told.on_message(json.dumps({"jsonrpc": "2.0", **answer}).encode())
    over.set()
    with pytest.raises(BenchFailed, match="instead of answer 0"):
        await working


async def test_a_wrong_answer_is_found() -> None:
    """A server that calls everything an invalid request."""

    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readuntil(b"\r\n\r\n")
        writer.write(b"HTTP/1.1 101 Switching Protocols\r\n\r\n")
        await reader.readexactly(1)
        text = b'{"jsonrpc":"2.0","id":null,"error":{"code":-32600,"message":""}}'
        end = b'{"jsonrpc":"2.0","id":"the last question","result":{"return_code":"OK"}}'
        for said in (*[text] * 10, end):
            writer.write(bytes((0x81, len(said))) + said)
        await writer.drain()
        writer.close()

    server = await asyncio.start_server(answer, "127.0.0.1", 0)
    async with server:
        port = server.sockets[0].getsockname()[1]
        found: Found = await flood(Door(f"http://127.0.0.1:{port}/"), 40, 0, seed=3)
    assert not found.right
    assert found.wrong
    assert found.missing
